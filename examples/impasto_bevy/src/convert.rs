//! What Bevy has, as impasto takes it: meshes, cameras, places, lights. The two have glam in different versions.

use bevy::light::DirectionalLight;
use bevy::mesh::{Mesh, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::{GlobalTransform, Mat4, Vec3};
use impasto::embed::HostDepth;
use impasto::scene::{self, Camera, Lights, Pose};
use impasto::{Error, Result};
use std::fmt::Display;

/// Makes an impasto mesh of a Bevy mesh: of a primitive, or of one that was loaded with a scene. It is one object.
///
/// # Errors
/// [`Error::Parameter`] unless it is a list of triangles with positions, whose asset is kept in the main world, and
/// what [`scene::Mesh::build`] refuses.
pub fn mesh(mesh: &Mesh) -> Result<scene::Mesh> {
    let refused = |what: &dyn Display| Error::parameter("mesh", what, "a list of triangles with positions in floats");
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err(refused(&"no list of triangles"));
    }
    let attribute = |attribute| match mesh.try_attribute_option(attribute) {
        Ok(Some(VertexAttributeValues::Float32x3(values))) => Ok(Some(values.clone())),
        Ok(_) => Ok(None),
        Err(error) => Err(refused(&error)),
    };
    let positions = attribute(Mesh::ATTRIBUTE_POSITION)?.ok_or_else(|| refused(&"no positions"))?;
    let indices: Vec<u32> = match mesh.try_indices_option().map_err(|error| refused(&error))? {
        Some(indices) => indices.iter().map(|index| index as u32).collect(),
        None => (0..positions.len() as u32).collect(),
    };
    let options = scene::MeshOptions::default();
    Ok(scene::Mesh::build(positions, attribute(Mesh::ATTRIBUTE_NORMAL)?, &indices, &[], &options)?.mesh)
}

/// A place in Bevy's world, as impasto has it: a pose, and a size.
///
/// impasto's poses are rigid. So lengths are measured in units of the object's size: the object is as large as its mesh
/// has it, and all distances from it are divided by its scale.
pub(crate) struct Place {
    pub pose: Pose,
    /// What world lengths are divided by.
    pub scale: f32,
}

impl Place {
    /// # Errors
    /// [`Error::Parameter`] for a scale that is not the same along all axes, or not above 0.
    pub fn new(transform: &GlobalTransform) -> Result<Self> {
        let (scale, rotation, translation) = transform.to_scale_rotation_translation();
        let (least, most) = (scale.min_element(), scale.max_element());
        if !(least > 0.0 && most <= least * 1.001) {
            return Err(Error::parameter("scale", scale, "above 0 and the same along all axes"));
        }
        let (axis, angle) = rotation.to_axis_angle();
        let way = vec3(translation / most);
        Ok(Self { pose: Pose::new(angle.to_degrees(), vec3(axis), scene::Vec3::ZERO, way)?, scale: most })
    }

    /// The camera of a view, in the object's lengths.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a projection that is no plain perspective.
    pub fn camera(&self, world_from_view: &GlobalTransform, clip_from_view: &Mat4) -> Result<Camera> {
        let mut view = world_from_view.to_matrix().inverse();
        view.w_axis = (view.w_axis.truncate() / self.scale).extend(1.0);
        Camera::from_matrices(&mat4(&view), &mat4(clip_from_view))
    }

    /// Depth in Bevy's buffer by distance along the view axis, in the object's lengths.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a projection that is no plain perspective.
    pub fn depth(&self, clip_from_view: &Mat4) -> Result<HostDepth> {
        let depth = HostDepth::from_projection(&mat4(clip_from_view))?;
        Ok(HostDepth { b: depth.b / self.scale, ..depth })
    }
}

/// The strongest directional lights, weighted by their illuminance; `None` where there is none.
pub(crate) fn lights<'a>(all: impl Iterator<Item = (&'a DirectionalLight, &'a GlobalTransform)>) -> Option<Lights> {
    let mut all: Vec<_> = all.filter(|(light, _)| light.illuminance > 0.0).collect();
    all.sort_by(|(a, _), (b, _)| b.illuminance.total_cmp(&a.illuminance));
    all.truncate(scene::MAX_LIGHTS);
    let most = all.first()?.0.illuminance;
    let lights = all.into_iter().map(|(light, transform)| {
        scene::DirectionalLight::new(vec3(transform.back().as_vec3()), light.illuminance / most).ok()
    });
    Lights::new(lights.flatten().collect::<Vec<_>>()).ok()
}

fn vec3(v: Vec3) -> scene::Vec3 {
    v.to_array().into()
}

fn mat4(m: &Mat4) -> scene::Mat4 {
    scene::Mat4::from_cols_array(&m.to_cols_array())
}
