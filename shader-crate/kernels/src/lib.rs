//! A compute shader for each canary of `relievo_kernel` and each kernel of
//! `relievo_shared`. Bindings of group 0: 0 words of the arguments, 1 words of the
//! results.
#![cfg(target_arch = "spirv")]
#![no_std]

use relievo_kernel::{entry_points, for_each_canary};
use relievo_shared::kernels::*;
use relievo_shared::{arithmetic, for_each_kernel, kernels};

for_each_canary!(entry_points);
for_each_kernel!(entry_points);
