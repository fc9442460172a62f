//! Outline of an Abaqus input file: its parts, their instances in the assembly, and the lines of neither.
//!
//! Source: "Abaqus Analysis User's Guide", "Defining an assembly".

use std::collections::{BTreeMap, HashMap};

use crate::ReadError;
use crate::inp_keyword::{INP, InpLine, InpLines, Keyword};
use crate::inp_placement::{Placement, PlacementLines};
use crate::inp_rigid::{RigidBodies, RigidElements, SetOwner};
use crate::text::{Line, Lines, quoted};

/// Parts and instances of a file, in its order.
#[derive(Debug, Default)]
pub(crate) struct Outline<'a> {
    pub(crate) parts: Vec<Section<'a>>,
    pub(crate) instances: Vec<Section<'a>>,
    /// Lines outside of all parts and instances.
    pub(crate) outside: Vec<Lines<'a>>,
    pub(crate) rigid: RigidBodies<'a>,
}

/// Part or instance.
#[derive(Debug)]
pub(crate) struct Section<'a> {
    pub(crate) name: Option<String>,
    /// Name of the part of which it is an instance.
    part: Option<String>,
    pub(crate) placement: Option<Placement>,
    /// True if nodes are defined in it.
    has_nodes: bool,
    /// Line of its keyword.
    pub(crate) line: usize,
    /// Lines below its keyword.
    pub(crate) lines: Lines<'a>,
}

/// Kind of the section that a line is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SectionKind {
    Part,
    Instance,
    Outside,
}

impl<'a> Outline<'a> {
    /// Reads the keywords of a file, and the data lines that place instances.
    pub(crate) fn read(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut lines = InpLines::new(Lines::new(bytes));
        let mut reader = OutlineReader::new(lines.rest());
        while let Some(line) = lines.next() {
            match line {
                InpLine::Keyword(keyword) => reader.read_keyword(&keyword, lines.rest()),
                InpLine::Data(line) => reader.read_data(&line)?,
            }
        }
        reader.end_placement();
        reader.end_section(bytes.len());
        Ok(reader.outline)
    }

    /// Returns true if the file has more than one part or instance.
    pub(crate) fn has_several(&self) -> bool {
        self.parts.len() > 1 || self.instances.len() > 1
    }

    /// Returns the name of the body of a file with one part or instance at most.
    pub(crate) fn only_name(&self) -> Option<&str> {
        let section = self.instances.first().or(self.parts.first())?;
        section.name.as_deref()
    }

    /// Returns the place of the part of each instance: `None` of one without a part, whose nodes are its own.
    pub(crate) fn parts_of_instances(&self) -> Result<Vec<Option<usize>>, ReadError> {
        let numbers = numbers_by_name(&self.parts, "part")?;
        numbers_by_name(&self.instances, "instance")?;
        let mut parts = Vec::new();
        for instance in &self.instances {
            let number = instance.part.as_ref().map(|part| {
                let number = numbers.get(&part.to_ascii_uppercase()).copied();
                let (instance_name, part) = (instance.quoted_name(), quoted(part));
                let problem =
                    format!("{instance_name} is of the part {part}, which is not defined");
                number.ok_or_else(|| INP.on_line(instance.line, problem))
            });
            if number.is_none() && !instance.has_nodes {
                let problem = format!("the instance {} without a part", instance.quoted_name());
                return Err(INP.unsupported(problem));
            }
            parts.push(number.transpose()?);
        }
        Ok(parts)
    }

    /// Returns the rigid elements of a part or an instance.
    pub(crate) fn rigid_elements(&self, section: &Section<'_>) -> Result<RigidElements, ReadError> {
        let name = section.name.as_deref().unwrap_or_default();
        let own = if self.instances.is_empty() {
            [SetOwner::part(name), SetOwner::part(name)]
        } else {
            let part = section.part.as_deref().unwrap_or_default();
            [SetOwner::instance(name), SetOwner::part(part)]
        };
        self.rigid.elements(|owner| own.contains(owner))
    }

    /// Returns the rigid elements of a file with one part or instance at most.
    pub(crate) fn rigid_elements_of_all(&self) -> Result<RigidElements, ReadError> {
        let is_flat = self.parts.is_empty() && self.instances.is_empty();
        self.rigid.elements(|owner| is_flat || *owner != SetOwner::Outside)
    }

    /// Returns the names of the instances that have the nodes of a part, by its name.
    pub(crate) fn instances_by_part(&self) -> Result<BTreeMap<String, Vec<String>>, ReadError> {
        let mut instances: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (instance, part) in self.instances.iter().zip(self.parts_of_instances()?) {
            let part = part.and_then(|part| self.parts[part].name.clone());
            if let (Some(part), Some(name), false) = (part, &instance.name, instance.has_nodes) {
                instances.entry(part).or_default().push(name.clone());
            }
        }
        Ok(instances)
    }
}

/// Reader of an outline.
#[derive(Debug)]
struct OutlineReader<'a> {
    outline: Outline<'a>,
    /// Kind of the section that is read, and the lines from its first one on.
    kind: SectionKind,
    start: Lines<'a>,
    /// Lines that place the instance that is read, up to its first other keyword.
    placement: Option<PlacementLines>,
    is_in_nodes: bool,
}

impl<'a> OutlineReader<'a> {
    fn new(lines: &Lines<'a>) -> Self {
        Self {
            outline: Outline::default(),
            kind: SectionKind::Outside,
            start: lines.clone(),
            placement: None,
            is_in_nodes: false,
        }
    }

    /// Reads a keyword, given the lines below it.
    fn read_keyword(&mut self, keyword: &Keyword<'_>, below: &Lines<'a>) {
        self.end_placement();
        self.is_in_nodes = keyword.is("NODE");
        let owner = self.set_owner();
        self.outline.rigid.read_keyword(keyword, owner, below);
        let Some(kind) = section_of(keyword) else { return };

        self.end_section(keyword.line.start);
        self.kind = kind;
        let is_outside = kind == SectionKind::Outside;
        self.start = if is_outside { below.back_to(&keyword.line) } else { below.clone() };
        let section = Section {
            name: keyword.value("NAME").map(str::to_owned),
            part: keyword.value("PART").map(str::to_owned),
            placement: None,
            has_nodes: false,
            line: keyword.line.number,
            lines: Lines::new(&[]),
        };
        match kind {
            SectionKind::Part => self.outline.parts.push(section),
            SectionKind::Instance => {
                self.outline.instances.push(section);
                self.placement = Some(PlacementLines::default());
            }
            SectionKind::Outside => {}
        }
    }

    /// Reads a data line, which may place an instance or be a node.
    fn read_data(&mut self, line: &Line<'_>) -> Result<(), ReadError> {
        if let Some(placement) = &mut self.placement {
            return placement.read(&INP, line);
        }
        if let (true, Some(section)) = (self.is_in_nodes, self.section()) {
            section.has_nodes = true;
        }
        Ok(())
    }

    /// Ends the lines that place an instance.
    fn end_placement(&mut self) {
        if let (Some(lines), Some(instance)) = (self.placement.take(), self.section()) {
            instance.placement = lines.placement();
        }
    }

    /// Ends the section that is read before a byte.
    fn end_section(&mut self, end: usize) {
        let lines = self.start.up_to(end);
        match self.section() {
            Some(section) => section.lines = lines,
            None => self.outline.outside.push(lines),
        }
    }

    /// Returns the owner of the sets that are read.
    fn set_owner(&mut self) -> SetOwner {
        let kind = self.kind;
        let name = self.section().and_then(|section| section.name.as_deref()).unwrap_or_default();
        match kind {
            SectionKind::Part => SetOwner::part(name),
            SectionKind::Instance => SetOwner::instance(name),
            SectionKind::Outside => SetOwner::Outside,
        }
    }

    /// Returns the part or instance that is read.
    fn section(&mut self) -> Option<&mut Section<'a>> {
        match self.kind {
            SectionKind::Part => self.outline.parts.last_mut(),
            SectionKind::Instance => self.outline.instances.last_mut(),
            SectionKind::Outside => None,
        }
    }
}

impl Section<'_> {
    fn quoted_name(&self) -> String {
        quoted(self.name.as_deref().unwrap_or_default())
    }
}

/// Returns the kind of section that a keyword begins, `None` where it begins none.
fn section_of(keyword: &Keyword<'_>) -> Option<SectionKind> {
    if keyword.is("PART") {
        Some(SectionKind::Part)
    } else if keyword.is("INSTANCE") {
        Some(SectionKind::Instance)
    } else {
        let ends = keyword.is_any(&["ENDPART", "ENDINSTANCE", "ASSEMBLY", "ENDASSEMBLY"]);
        ends.then_some(SectionKind::Outside)
    }
}

/// Returns the places of sections by their names in upper case, of which none may be missing or there twice.
fn numbers_by_name(
    sections: &[Section<'_>],
    noun: &str,
) -> Result<HashMap<String, usize>, ReadError> {
    let mut numbers = HashMap::new();
    for (number, section) in sections.iter().enumerate() {
        let Some(name) = &section.name else {
            return Err(INP.on_line(section.line, format!("{noun} {} has no name", number + 1)));
        };
        if numbers.insert(name.to_ascii_uppercase(), number).is_some() {
            let problem = format!("a second {noun} is named {}", quoted(name));
            return Err(INP.on_line(section.line, problem));
        }
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_of_one_section() {
        let file = "*Heading\nA\n*Part, name=p\n*Node\n1\n*End Part\n** c\n*Part, name=q\n2\n*Assembly\n\
                    *Instance, name=i, part=P\n1., 0, 0\n\n*Nset\n3\n*End Instance\n*Node\n4\n*End Assembly\n";
        let outline = Outline::read(file.as_bytes()).expect("a file");
        let texts = |lines: &Lines<'_>| {
            let texts = lines.clone().map(|line| String::from_utf8_lossy(line.text).into_owned());
            texts.collect::<Vec<_>>().join("|")
        };
        let parts: Vec<_> = outline.parts.iter().map(|part| texts(&part.lines)).collect();
        assert_eq!(parts, ["*Node|1", "2"]);
        let nodes: Vec<_> = outline.parts.iter().map(|part| part.has_nodes).collect();
        assert_eq!(nodes, [true, false]);
        let outside: Vec<_> = outline.outside.iter().map(texts).collect();
        assert_eq!(
            outside,
            ["*Heading|A", "*End Part|** c", "*Assembly", "*End Instance|*Node|4", "*End Assembly"]
        );
        let instance = &outline.instances[0];
        assert_eq!(texts(&instance.lines), "1., 0, 0||*Nset|3");
        assert_eq!((instance.line, instance.has_nodes), (11, false));
        assert!(instance.placement.is_some(), "it is moved along x");
        let numbers: Vec<_> = instance.lines.clone().map(|line| line.number).collect();
        assert_eq!(numbers, [12, 13, 14, 15]);
        assert_eq!(outline.parts_of_instances().expect("parts"), [Some(0)]);
    }
}
