use super::*;

/// A module of these instructions, opcode and operands.
fn module(instructions: &[(u32, &[u32])]) -> Vec<u8> {
    let mut words = vec![MAGIC, 0x1_0300, 0, 100, 0];
    for (opcode, operands) in instructions {
        words.push((operands.len() as u32 + 1) << 16 | opcode);
        words.extend(*operands);
    }
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// `"main"`, in little-endian words.
const MAIN: [u32; 2] = [0x6e69_616d, 0];

fn fragment() -> Vec<(u32, &'static [u32])> {
    const ENTRY: [u32; 4] = [4, 1, MAIN[0], MAIN[1]];
    vec![
        (OP_ENTRY_POINT, &ENTRY),
        (OP_DECORATE, &[10, DESCRIPTOR_SET, 0]),
        (OP_DECORATE, &[10, BINDING, 3]),
        (OP_DECORATE, &[11, DESCRIPTOR_SET, 1]),
        (OP_DECORATE, &[11, BINDING, 0]),
        (OP_DECORATE, &[12, LOCATION, 1]),
        (OP_TYPE_INT, &[2, 32, 0]),
        (OP_TYPE_VECTOR, &[3, 2, 4]),
        (OP_TYPE_STRUCT, &[4, 2]),
        (OP_TYPE_IMAGE, &[5, 2, 1, 0, 0, 0, 1, 0]),
        (OP_TYPE_POINTER, &[6, STORAGE_BUFFER, 4]),
        (OP_TYPE_POINTER, &[7, UNIFORM_CONSTANT, 5]),
        (OP_TYPE_POINTER, &[8, OUTPUT, 3]),
        (OP_VARIABLE, &[6, 10, STORAGE_BUFFER]),
        (OP_VARIABLE, &[7, 11, UNIFORM_CONSTANT]),
        (OP_VARIABLE, &[8, 12, OUTPUT]),
        (OP_F_DIV, &[9, 20, 21, 22]),
        (OP_EXT_INST, &[9, 23, 30, SQRT, 20]),
        (OP_EXT_INST, &[9, 24, 30, FMA, 20, 20, 20]),
        (OP_F_DIV, &[9, 25, 21, 22]),
    ]
}

#[test]
fn resources_outputs_and_operations_are_found() {
    let shader = Shader::read(&module(&fragment())).unwrap();
    assert_eq!(
        (shader.name().as_str(), shader.stage),
        ("main", Stage::Fragment)
    );
    let bindings = [
        ((0, 3), Binding::StorageBuffer),
        ((1, 0), Binding::SampledImage),
    ];
    assert_eq!(shader.bindings, bindings.into());
    assert_eq!(shader.targets, [(1, Target::Unsigned)].into());
    assert_eq!((shader.divisions, shader.roots, shader.fused), (2, 1, 1));
}

#[test]
fn what_cannot_be_compiled_alone_is_refused() {
    let refused = |bytes: &[u8]| Shader::read(bytes).unwrap_err().to_string();
    assert!(refused(b"no SPIR-V here, sorry!!!").contains("header"));
    assert!(refused(&module(&[])).contains("not one entry point"));
    let mut cut = module(&fragment());
    cut.truncate(cut.len() - 4);
    assert!(refused(&cut).contains("wrong length"));
    let mut constants = fragment();
    constants.push((OP_VARIABLE, &[6, 13, PUSH_CONSTANT]));
    assert!(refused(&module(&constants)).contains("push constants (variable %13)"));
    let mut array = fragment();
    array.push((OP_VARIABLE, &[8, 13, UNIFORM]));
    assert!(refused(&module(&array)).contains("no single buffer"));
}
