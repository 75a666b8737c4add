//! Translates an object's shaders to a shading language with naga: reads SPIR-V, names
//! its variables, and adapts it to language and output.

use super::interface::Interface;
use super::layout::{Binding, Element, Struct};
use super::target::{Output, Stage};
use naga::{
    Arena, ArraySize, Block, BuiltIn, Expression, Function, Handle, Literal, Module, Range,
    ResourceBinding, Scalar, ScalarKind, Span, Statement, StructMember, Type, TypeInner,
    VectorSize,
};
use relievo_translate::portable;
use relievo_translate::{METAL_SIZES, Target, Written, finish};

/// Replaces the picture of exits by zeros, which say that no exit is known.
fn remove_exits(module: &mut Module) {
    let inner = TypeInner::Vector {
        size: VectorSize::Quad,
        scalar: Scalar::U32,
    };
    let words = module
        .types
        .insert(Type { name: None, inner }, Span::UNDEFINED);
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entry_points = module.entry_points.iter_mut();
    for function in functions.chain(entry_points.map(|entry| &mut entry.function)) {
        let mut reads = Vec::new();
        for (handle, expression) in function.expressions.iter_mut() {
            if let Expression::ImageLoad { .. } = expression {
                *expression = Expression::ZeroValue(words);
                reads.push(handle);
            }
        }
        // Zeros are not computed by statements.
        if !reads.is_empty() {
            skip_emits(&mut function.body, &reads);
        }
    }
}

/// Removes expressions from the statements that compute them.
fn skip_emits(block: &mut Block, skipped: &[Handle<Expression>]) {
    let mut rest = Block::new();
    for (mut statement, span) in std::mem::take(block).span_into_iter() {
        match &mut statement {
            Statement::Emit(range) => {
                let kept = range.clone().filter(|computed| !skipped.contains(computed));
                for handle in kept {
                    rest.push(
                        Statement::Emit(Range::new_from_bounds(handle, handle)),
                        span,
                    );
                }
                continue;
            }
            Statement::Block(inner) => skip_emits(inner, skipped),
            Statement::If { accept, reject, .. } => {
                skip_emits(accept, skipped);
                skip_emits(reject, skipped);
            }
            Statement::Switch { cases, .. } => {
                for case in cases {
                    skip_emits(&mut case.body, skipped);
                }
            }
            Statement::Loop {
                body, continuing, ..
            } => {
                skip_emits(body, skipped);
                skip_emits(continuing, skipped);
            }
            _ => {}
        }
        rest.push(statement, span);
    }
    *block = rest;
}

/// Translates the shader in `words` (SPIR-V with one entry point) to `target`.
///
/// # Errors
/// The reason why the compiled shader cannot be translated.
pub(super) fn translate(
    words: &[u32],
    stage: Stage,
    bindings: &[Binding],
    structs: &[Struct],
    output: Output,
    target: Target,
    interface: &Interface,
) -> Result<Written, String> {
    let mut module = portable::read(words)?;
    remove_exits(&mut module);
    name(&mut module, bindings, structs)?;
    let [entry_point] = module.entry_points.as_mut_slice() else {
        return Err("it does not have exactly one entry point".to_string());
    };
    if entry_point.stage != stage.naga() {
        return Err(format!("it is not a {} shader", stage.name()));
    }
    entry_point.name = stage.entry_point().to_string();
    if stage == Stage::Fragment {
        if output == Output::Color {
            write_color(&mut module).ok_or("its colour output has an unknown form")?;
        }
        if target == Target::Glsl {
            count_rows_upwards(&mut module)
                .ok_or("its pixel position is read in an unknown form")?;
        }
    }
    interface.place(&mut module);
    finish(&mut module, target, METAL_SIZES)
}

/// Names the buffers, structs and fields, which have no names in the SPIR-V. Fails if
/// a field has another type or offset than in the table.
pub(super) fn name(
    module: &mut Module,
    bindings: &[Binding],
    structs: &[Struct],
) -> Result<(), String> {
    for binding in bindings {
        let wanted = ResourceBinding {
            group: 0,
            binding: binding.number,
        };
        let found = module
            .global_variables
            .iter_mut()
            .find(|(_, variable)| variable.binding == Some(wanted));
        let Some((_, variable)) = found else {
            // Vertex shaders read no texels.
            continue;
        };
        variable.name = Some(binding.name.to_string());
        let wrapper = variable.ty;
        let TypeInner::Struct { members, span } = &module.types[wrapper].inner else {
            return Err(format!("binding {} is not a struct", binding.number));
        };
        let ([member], span) = (members.as_slice(), *span) else {
            return Err(format!("binding {} has several members", binding.number));
        };
        let member = StructMember {
            name: Some("at".to_string()),
            ..member.clone()
        };
        let contents = match module.types[member.ty].inner {
            TypeInner::Array {
                base,
                size: ArraySize::Dynamic,
                ..
            } if binding.is_array => base,
            _ if binding.is_array => {
                return Err(format!("binding {} is not an array", binding.number));
            }
            _ => member.ty,
        };
        name_type(module, contents, binding.element, structs)?;
        let title = match binding.element {
            Element::Struct(name) => format!("{name}Data"),
            Element::F32 | Element::U32 => "WordData".to_string(),
        };
        let inner = TypeInner::Struct {
            members: vec![member],
            span,
        };
        rename(module, wrapper, title, inner);
    }
    Ok(())
}

/// Names a struct, its fields and the structs in it.
fn name_type(
    module: &mut Module,
    handle: Handle<Type>,
    element: Element,
    structs: &[Struct],
) -> Result<(), String> {
    let inner = module.types[handle].inner.clone();
    let name = match (element, &inner) {
        (Element::F32, TypeInner::Scalar(Scalar::F32))
        | (Element::U32, TypeInner::Scalar(Scalar::U32)) => return Ok(()),
        (Element::Struct(name), _) => name,
        _ => return Err(format!("a number is not a {}", element.name())),
    };
    let described = structs.iter().find(|described| described.name == name);
    let (Some(described), TypeInner::Struct { mut members, span }) = (described, inner) else {
        return Err(format!("{name} is not a struct"));
    };
    let offsets = members.iter().map(|member| member.offset as usize);
    let known = described.fields.iter().map(|field| field.offset);
    if !offsets.eq(known) || span as usize != described.size {
        return Err(format!("{name} has another layout"));
    }
    for (member, field) in members.iter_mut().zip(&described.fields) {
        let mut contents = member.ty;
        for side in &field.kind.shape {
            match module.types[contents].inner {
                TypeInner::Array {
                    base,
                    size: ArraySize::Constant(size),
                    ..
                } if size.get() as usize == *side => contents = base,
                _ => return Err(format!("{name}.{} has another type", field.name)),
            }
        }
        name_type(module, contents, field.kind.element, structs)?;
        member.name = Some(field.name.to_string());
    }
    rename(
        module,
        handle,
        name.to_string(),
        TypeInner::Struct { members, span },
    );
    Ok(())
}

/// Replaces a struct without a name by a named one.
fn rename(module: &mut Module, handle: Handle<Type>, name: String, inner: TypeInner) {
    let named = Type {
        name: Some(name),
        inner,
    };
    if module.types.get(&named).is_none() {
        module.types.replace(handle, named);
    }
}

/// Appends expressions, with the statements that evaluate them.
struct Appender<'a> {
    expressions: &'a mut Arena<Expression>,
    body: Vec<Statement>,
}

impl Appender<'_> {
    /// Appends an expression that needs no evaluation: a literal or a pointer to a
    /// variable.
    fn place(&mut self, expression: Expression) -> Handle<Expression> {
        self.expressions.append(expression, Span::UNDEFINED)
    }

    /// Appends an expression and its evaluation.
    fn compute(&mut self, expression: Expression) -> Handle<Expression> {
        let handle = self.place(expression);
        self.body
            .push(Statement::Emit(Range::new_from_bounds(handle, handle)));
        handle
    }

    /// Appends an access to component `index` of a vector, or a pointer to it.
    fn component(&mut self, base: Handle<Expression>, index: u32) -> Handle<Expression> {
        self.compute(Expression::AccessIndex { base, index })
    }
}

/// Returns the type `vec4<f32>`.
fn vec4_f32(module: &mut Module) -> Handle<Type> {
    let inner = TypeInner::Vector {
        size: VectorSize::Quad,
        scalar: Scalar::F32,
    };
    let kind = Type { name: None, inner };
    module.types.insert(kind, Span::UNDEFINED)
}

/// Changes the output at location 0 from words to linear RGB with an alpha of 1, with
/// the same bits.
fn write_color(module: &mut Module) -> Option<()> {
    let vec4 = vec4_f32(module);
    let function = &module.entry_points[0].function;
    let result = function.result.clone()?;
    let TypeInner::Struct { mut members, span } = module.types[result.ty].inner.clone() else {
        return None;
    };
    let is_color = |member: &StructMember| {
        matches!(
            member.binding,
            Some(naga::Binding::Location { location: 0, .. })
        )
    };
    let index = members.iter().position(is_color)?;
    members[index].ty = vec4;
    let inner = TypeInner::Struct { members, span };
    let name = Some("FragmentOutput".to_string());
    let ty = module.types.insert(Type { name, inner }, Span::UNDEFINED);

    let function: &mut Function = &mut module.entry_points[0].function;
    let last = function.body.len().checked_sub(1)?;
    let Statement::Return { value: Some(value) } = function.body[last] else {
        return None;
    };
    let Expression::Compose { mut components, .. } = function.expressions[value].clone() else {
        return None;
    };
    let mut appender = Appender {
        expressions: &mut function.expressions,
        body: Vec::new(),
    };
    let opaque = appender.place(Expression::Literal(Literal::F32(1.0)));
    let bits = appender.compute(Expression::As {
        expr: *components.get(index)?,
        kind: ScalarKind::Float,
        convert: None,
    });
    let rgb = [0, 1, 2].map(|channel| appender.component(bits, channel));
    components[index] = appender.compute(Expression::Compose {
        ty: vec4,
        components: rgb.into_iter().chain([opaque]).collect(),
    });
    let value = appender.compute(Expression::Compose { ty, components });
    let body = appender.body;
    function.body.cull(last..);
    for statement in body {
        function.body.push(statement, Span::UNDEFINED);
    }
    function
        .body
        .push(Statement::Return { value: Some(value) }, Span::UNDEFINED);
    function.result.as_mut()?.ty = ty;
    Some(())
}

/// Flips the pixel's row: OpenGL counts rows from the bottom, the shader from the top.
fn count_rows_upwards(module: &mut Module) -> Option<()> {
    let vec4 = vec4_f32(module);
    let (frames, _) = module.global_variables.iter().find(|(_, variable)| {
        let binding = variable.binding.as_ref();
        binding.is_some_and(|binding| (binding.group, binding.binding) == (0, 0))
    })?;
    let TypeInner::Struct { members, .. } = &module.types[module.global_variables[frames].ty].inner
    else {
        return None;
    };
    let TypeInner::Array { base, .. } = module.types[members.first()?.ty].inner else {
        return None;
    };
    let TypeInner::Struct { members, .. } = &module.types[base].inner else {
        return None;
    };
    let size = (0..)
        .zip(members)
        .find(|(_, member)| member.name.as_deref() == Some("size"))?
        .0;

    let function: &mut Function = &mut module.entry_points[0].function;
    let is_pixel = |argument: &naga::FunctionArgument| {
        matches!(
            argument.binding,
            Some(naga::Binding::BuiltIn(BuiltIn::Position { .. }))
        )
    };
    let argument = function.arguments.iter().position(is_pixel)? as u32;
    let is_argument = |expression: &Expression| matches!(expression, Expression::FunctionArgument(index) if *index == argument);
    let (pixel, _) = function
        .expressions
        .iter()
        .find(|(_, expression)| is_argument(expression))?;
    let mut appender = Appender {
        expressions: &mut function.expressions,
        body: Vec::new(),
    };
    let frames = appender.place(Expression::GlobalVariable(frames));
    let frames = appender.component(frames, 0);
    let frame = appender.component(frames, 0);
    let size = appender.component(frame, size);
    let height = appender.component(size, 1);
    let height = appender.compute(Expression::Load { pointer: height });
    let [x, y, z, w] = [0, 1, 2, 3].map(|index| appender.component(pixel, index));
    let y = appender.compute(Expression::Binary {
        op: naga::BinaryOperator::Subtract,
        left: height,
        right: y,
    });
    let turned = appender.compute(Expression::Compose {
        ty: vec4,
        components: vec![x, y, z, w],
    });
    let body = appender.body;
    // The rest of the function reads it from the variable where it is stored.
    let stored = function
        .body
        .iter_mut()
        .find_map(|statement| match statement {
            Statement::Store { value, .. } if *value == pixel => Some(value),
            _ => None,
        })?;
    *stored = turned;
    let mut first = naga::Block::new();
    for statement in body {
        first.push(statement, Span::UNDEFINED);
    }
    function.body.splice(0..0, first);
    Some(())
}
