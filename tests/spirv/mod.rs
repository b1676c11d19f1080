//! What a SPIR-V binary says of itself: the little of it that the tests of the shaders look at.

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{BuiltIn, Decoration, ExecutionMode, Op, StorageClass, Word};

/// One member of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Member {
    pub offset: u32,
    pub bytes: u32,
}

/// One descriptor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Resource {
    pub set: u32,
    pub binding: u32,
    pub class: &'static str,
    pub non_writable: bool,
    pub non_readable: bool,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binary {
    pub version: (u8, u8),
    pub capabilities: Vec<String>,
    /// Extensions, and sets of extended instructions.
    pub extensions: Vec<String>,
    pub entry_points: Vec<String>,
    /// Of compute shaders only.
    pub local_size: Option<[u32; 3]>,
    pub shared_bytes: u32,
    /// By binding.
    pub resources: Vec<Resource>,
    pub push: Vec<Member>,
    /// Stride and members of every runtime array of structures.
    pub arrays_of_structs: Vec<(u32, Vec<Member>)>,
}

impl Binary {
    pub fn parse(bytes: &[u8]) -> Self {
        let module = rspirv::dr::load_bytes(bytes).expect("SPIR-V");
        let of = Reader { module: &module };
        let text = |i: &Instruction, at: usize| i.operands[at].unwrap_literal_string().to_owned();
        let globals = &module.types_global_values;
        let variables = |wanted: StorageClass| {
            globals
                .iter()
                .filter(move |i| i.class.opcode == Op::Variable && i.operands[0] == Operand::StorageClass(wanted))
        };
        let mut resources: Vec<_> = globals.iter().filter_map(|i| of.resource(i)).collect();
        resources.sort_by_key(|r| (r.set, r.binding));
        Binary {
            version: module.header.as_ref().expect("a header").version(),
            capabilities: module
                .capabilities
                .iter()
                .map(|i| format!("{:?}", i.operands[0].unwrap_capability()))
                .collect(),
            extensions: module.extensions.iter().chain(&module.ext_inst_imports).map(|i| text(i, 0)).collect(),
            entry_points: module.entry_points.iter().map(|i| text(i, 2)).collect(),
            local_size: of.local_size(),
            shared_bytes: variables(StorageClass::Workgroup).map(|i| of.bytes(of.pointee(i))).sum(),
            resources,
            push: variables(StorageClass::PushConstant).flat_map(|i| of.members(of.pointee(i))).collect(),
            arrays_of_structs: globals
                .iter()
                .filter(|i| i.class.opcode == Op::TypeRuntimeArray)
                .filter(|i| of.get(id(&i.operands[0])).class.opcode == Op::TypeStruct)
                .map(|i| {
                    let stride = of.decoration(i.result_id.expect("a type"), Decoration::ArrayStride);
                    (stride.expect("a stride"), of.members(id(&i.operands[0])))
                })
                .collect(),
        }
    }

    pub fn push_bytes(&self) -> u32 {
        self.push.iter().map(|m| m.offset + m.bytes).max().unwrap_or(0)
    }
}

fn id(operand: &Operand) -> Word {
    operand.id_ref_any().expect("an id")
}

struct Reader<'a> {
    module: &'a Module,
}

impl Reader<'_> {
    /// The instruction that makes a global id.
    fn get(&self, wanted: Word) -> &Instruction {
        let mut all = self.module.types_global_values.iter();
        all.find(|i| i.result_id == Some(wanted)).expect("a global")
    }

    /// The type behind a variable's pointer.
    fn pointee(&self, variable: &Instruction) -> Word {
        id(&self.get(variable.result_type.expect("a type")).operands[1])
    }

    fn decorations(&self, target: Word) -> impl Iterator<Item = &[Operand]> {
        let all = self.module.annotations.iter();
        all.filter(move |i| i.class.opcode == Op::Decorate && id(&i.operands[0]) == target).map(|i| &i.operands[1..])
    }

    /// A decoration's number, 0 where it has none.
    fn decoration(&self, target: Word, wanted: Decoration) -> Option<u32> {
        self.decorations(target).find(|d| d[0] == Operand::Decoration(wanted)).map(number)
    }

    fn member_decoration(&self, target: Word, member: u32, wanted: Decoration) -> Option<u32> {
        let all = self.module.annotations.iter().filter(|i| i.class.opcode == Op::MemberDecorate);
        let mut of_member = all.filter(|i| {
            id(&i.operands[0]) == target
                && i.operands[1] == Operand::LiteralBit32(member)
                && i.operands[2] == Operand::Decoration(wanted)
        });
        of_member.next().map(|i| number(&i.operands[2..]))
    }

    fn constant(&self, of: Word) -> u32 {
        match self.get(of).operands[0] {
            Operand::LiteralBit32(value) => value,
            ref other => panic!("{other:?} is not a 32-bit constant"),
        }
    }

    /// Size of a type without padding.
    fn bytes(&self, of: Word) -> u32 {
        let made = self.get(of);
        match made.class.opcode {
            Op::TypeInt | Op::TypeFloat => match made.operands[0] {
                Operand::LiteralBit32(bits) => bits / 8,
                ref other => panic!("{other:?} is not a width"),
            },
            Op::TypeBool => 4,
            Op::TypeVector | Op::TypeMatrix => match made.operands[1] {
                Operand::LiteralBit32(count) => self.bytes(id(&made.operands[0])) * count,
                ref other => panic!("{other:?} is not a count"),
            },
            Op::TypeArray => self.bytes(id(&made.operands[0])) * self.constant(id(&made.operands[1])),
            Op::TypeStruct => made.operands.iter().map(|member| self.bytes(id(member))).sum(),
            other => panic!("size of {other:?}"),
        }
    }

    fn members(&self, of: Word) -> Vec<Member> {
        let member = |(i, one): (u32, &Operand)| Member {
            offset: self.member_decoration(of, i, Decoration::Offset).expect("an offset"),
            bytes: self.bytes(id(one)),
        };
        (0..).zip(&self.get(of).operands).map(member).collect()
    }

    /// The local size, by mode and by built-in constant, which must agree where both are there.
    fn local_size(&self) -> Option<[u32; 3]> {
        let mut modes = self.module.execution_modes.iter();
        let mode = modes.find(|i| i.operands[1] == Operand::ExecutionMode(ExecutionMode::LocalSize))?;
        let size = [2, 3, 4].map(|at| number(&mode.operands[at - 1..]));
        for i in self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::ConstantComposite) {
            let target = i.result_id.expect("a constant");
            let built_in = [Operand::Decoration(Decoration::BuiltIn), Operand::BuiltIn(BuiltIn::WorkgroupSize)];
            if self.decorations(target).any(|d| d == built_in) {
                let constant: Vec<_> = i.operands.iter().map(|c| self.constant(id(c))).collect();
                assert_eq!(constant, size, "two sizes of a workgroup");
            }
        }
        Some(size)
    }

    fn resource(&self, variable: &Instruction) -> Option<Resource> {
        let me = variable.result_id?;
        if variable.class.opcode != Op::Variable {
            return None;
        }
        let binding = self.decoration(me, Decoration::Binding)?;
        let pointee = self.pointee(variable);
        let made = self.get(pointee);
        let class = match (variable.operands[0].unwrap_storage_class(), made.class.opcode) {
            (StorageClass::StorageBuffer, Op::TypeStruct) => "storage buffer",
            // Operand 5 of an image type: 2 means that it is used without a sampler.
            (StorageClass::UniformConstant, Op::TypeSampledImage) => "sampled image",
            (StorageClass::UniformConstant, Op::TypeImage) if made.operands[5] == Operand::LiteralBit32(2) => {
                "storage image"
            }
            other => panic!("a resource of {other:?}"),
        };
        // A buffer block carries the words on its members, an image on itself.
        let says = |wanted| {
            let members = if made.class.opcode == Op::TypeStruct { made.operands.len() as u32 } else { 0 };
            let on_members = (0..members).all(|m| self.member_decoration(pointee, m, wanted).is_some());
            self.decoration(me, wanted).is_some() || (members > 0 && on_members)
        };
        Some(Resource {
            set: self.decoration(me, Decoration::DescriptorSet)?,
            binding,
            class,
            non_writable: says(Decoration::NonWritable),
            non_readable: says(Decoration::NonReadable),
        })
    }
}

/// The number that follows a decoration or a mode; 0 where none does.
fn number(of: &[Operand]) -> u32 {
    match of.get(1) {
        Some(Operand::LiteralBit32(value)) => *value,
        _ => 0,
    }
}
