//! Accessors: arrays of vectors or numbers in buffers.

use gltf::Accessor;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;

use super::buffers::Buffers;
use super::problem::Problem;

/// An accessor whose elements are read on use.
pub(super) struct Numbers<'a> {
    pub count: usize,
    pub kind: DataType,
    is_normalized: bool,
    /// `None` stands for zeros.
    base: Option<Run<'a>>,
    sparse: Option<Sparse<'a>>,
}

/// Elements at a constant stride.
#[derive(Clone, Copy)]
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace others (a sparse accessor).
struct Sparse<'a> {
    count: usize,
    kind: DataType,
    indices: Run<'a>,
    values: Run<'a>,
}

impl<'a> Numbers<'a> {
    pub fn new(
        accessor: &Accessor<'_>,
        dimensions: Dimensions,
        buffers: &'a Buffers<'_>,
        what: &str,
    ) -> Result<Numbers<'a>, Problem> {
        if accessor.dimensions() != dimensions {
            return Err(format!(
                "its {what} have the type {:?} instead of {dimensions:?}; export it again",
                accessor.dimensions()
            )
            .into());
        }
        let (count, size) = (accessor.count(), accessor.size());
        let base = accessor.view();
        let base = base.map(|view| Run::new(&view, accessor.offset(), count, size, buffers));
        let sparse = accessor.sparse().filter(|sparse| sparse.count() > 0);
        let sparse = sparse.map(|sparse| {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind = match indices.index_type() {
                IndexType::U8 => DataType::U8,
                IndexType::U16 => DataType::U16,
                IndexType::U32 => DataType::U32,
            };
            let places = Run::new(
                &indices.view(),
                indices.offset(),
                sparse.count(),
                indices.index_type().size(),
                buffers,
            );
            let values = Run::new(
                &values.view(),
                values.offset(),
                sparse.count(),
                size,
                buffers,
            );
            Ok::<_, Problem>(Sparse {
                count: sparse.count(),
                kind,
                indices: places?,
                values: values?,
            })
        });
        let sparse = sparse.transpose()?;
        if let Some(sparse) = &sparse {
            let place = |index| sparse.place(index);
            if (1..sparse.count).any(|index| place(index - 1) >= place(index)) {
                return Err(format!(
                    "the sparse indices of its {what} are not increasing; export it again"
                )
                .into());
            }
        }
        Ok(Numbers {
            count,
            kind: accessor.data_type(),
            is_normalized: accessor.normalized(),
            base: base.transpose()?,
            sparse,
        })
    }

    /// Returns those of `bytes`: `count` elements of `components` numbers each, one after the other.
    pub fn packed(
        bytes: &'a [u8],
        count: usize,
        kind: DataType,
        components: usize,
        is_normalized: bool,
    ) -> Numbers<'a> {
        let stride = components * kind.size();
        Numbers {
            count,
            kind,
            is_normalized,
            base: Some(Run { bytes, stride }),
            sparse: None,
        }
    }

    /// Returns the element at `index`.
    pub fn get<const N: usize>(&self, index: usize) -> Result<[f64; N], Problem> {
        if index >= self.count {
            return Err(format!("it has no element {index}; export it again").into());
        }
        let sparse = self.sparse.as_ref();
        let element = match sparse.and_then(|sparse| sparse.element(index)) {
            Some(element) => element,
            None => match self.base {
                Some(run) => run.element(index),
                None => return Ok([0.0; N]),
            },
        };
        let size = self.kind.size();
        Ok(std::array::from_fn(|i| {
            number(&element[i * size..], self.kind, self.is_normalized)
        }))
    }
}

impl<'a> Run<'a> {
    /// Creates a run of `count` elements of `size` bytes, from `offset` on.
    fn new(
        view: &View<'_>,
        offset: usize,
        count: usize,
        size: usize,
        buffers: &'a Buffers<'_>,
    ) -> Result<Run<'a>, Problem> {
        let bytes = buffers.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let end = count.checked_sub(1).and_then(|last| {
            last.checked_mul(stride)?
                .checked_add(size)?
                .checked_add(offset)
        });
        let bytes = end.and_then(|end| bytes.get(offset..end));
        match bytes {
            Some(bytes) if stride >= size => Ok(Run { bytes, stride }),
            _ => Err(format!(
                "{count} elements of {size} bytes do not fit buffer view {}; export it again",
                view.index()
            )
            .into()),
        }
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

impl<'a> Sparse<'a> {
    /// Returns the index of the element that the one at `index` replaces.
    fn place(&self, index: usize) -> usize {
        number(self.indices.element(index), self.kind, false) as usize
    }

    /// Returns the replacement of element `wanted`, if any, by binary search.
    fn element(&self, wanted: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.place(middle).cmp(&wanted) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Equal => return Some(self.values.element(middle)),
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        None
    }
}

/// Decodes the number at the start of `bytes`.
fn number(bytes: &[u8], kind: DataType, is_normalized: bool) -> f64 {
    let (value, largest) = match kind {
        DataType::I8 => (f64::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f64::from(bytes[0]), 255.0),
        DataType::I16 => (
            f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            32_767.0,
        ),
        DataType::U16 => (
            f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            65_535.0,
        ),
        DataType::U32 => {
            let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
            (f64::from(u32::from_le_bytes(word)), f64::from(u32::MAX))
        }
        DataType::F32 => {
            let word = [bytes[0], bytes[1], bytes[2], bytes[3]];
            return f64::from(f32::from_le_bytes(word));
        }
    };
    if is_normalized {
        // Two's complement has one more negative number.
        (value / largest).max(-1.0)
    } else {
        value
    }
}
