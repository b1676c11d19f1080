//! What was dropped or repaired on the way to a usable mesh: said with its amount, never silently.

use std::fmt;

/// One kind of flaw that was found in a model, with how much of it there was, and what was done about it.
///
/// The text of `Display` is meant for the user: "dropped 200 triangles of zero area".
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshWarning {
    /// Vertices with a coordinate that is NaN, infinite or beyond 1e12, and the triangles that were dropped with them.
    BadPositions {
        /// Vertices that were used by a face and are not usable.
        vertices: usize,
        /// Triangles that used them.
        triangles: usize,
    },
    /// Triangles without area: two equal corners, or three on a line as far as single precision can tell.
    ZeroArea {
        /// Triangles that were dropped.
        triangles: usize,
    },
    /// Normals that were given, but are zero or not finite. They were computed instead.
    BadNormals {
        /// Vertices that had such a normal.
        vertices: usize,
    },
    /// Vertices without a normal in a model that has normals elsewhere. They were computed.
    ///
    /// A model that has no normals at all is usual, and gives no warning.
    SomeNormalsMissing {
        /// Vertices without a normal.
        vertices: usize,
    },
    /// Triangles whose corners ran the other way around than their normals say. Their winding was turned.
    WindingTurned {
        /// Triangles that were turned.
        triangles: usize,
    },
    /// Faces with fewer than three corners. They were dropped.
    ShortFaces {
        /// Faces that were dropped.
        faces: usize,
    },
    /// Faces that cross themselves, or are too intricate to cut exactly. They were cut as well as possible.
    CrossingFaces {
        /// Faces that are affected.
        faces: usize,
    },
    /// Line and point elements (`l` and `p`), which have no surface to shade. They were left out.
    LinesAndPoints {
        /// Elements that were left out.
        elements: usize,
    },
    /// Objects of which no triangle was left. They keep their place in the list, with an `index_count` of 0.
    EmptiedObjects {
        /// Objects without a triangle.
        objects: usize,
    },
}

impl fmt::Display for MeshWarning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Self::BadPositions { vertices, triangles } => {
                write!(f, "dropped {} that use ", count(triangles, "triangle"))?;
                write!(f, "{} with a coordinate that is not finite or beyond 1e12", count(vertices, "vertex"))
            }
            Self::ZeroArea { triangles } => write!(f, "dropped {} of zero area", count(triangles, "triangle")),
            Self::BadNormals { vertices } => {
                write!(f, "replaced {} that are zero or not finite", count(vertices, "normal"))
            }
            Self::SomeNormalsMissing { vertices } => {
                write!(f, "computed the normals of {}, which have none while others do", count(vertices, "vertex"))
            }
            Self::WindingTurned { triangles } => {
                write!(f, "turned the winding of {} to agree with the normals", count(triangles, "triangle"))
            }
            Self::ShortFaces { faces } => write!(f, "dropped {} with fewer than three corners", count(faces, "face")),
            Self::CrossingFaces { faces } => {
                write!(f, "cut {} as well as possible, crossing or too intricate", count(faces, "face"))
            }
            Self::LinesAndPoints { elements } => {
                write!(f, "left out {}, which have no surface", count(elements, "line or point element"))
            }
            Self::EmptiedObjects { objects } => write!(f, "{} without a usable triangle", count(objects, "object")),
        }
    }
}

/// "1 triangle", "2 vertices".
fn count(n: usize, noun: &str) -> String {
    match (n, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{n} vertices"),
        _ => format!("{n} {noun}s"),
    }
}
