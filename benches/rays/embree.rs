//! Embree as the reference, if this machine has it (Debian: `apt-get install libembree-dev`).
//!
//! Its library is opened at run time, so that the bench builds without it. The names and layouts
//! are those of its C interface, versions 3 and 4.

#![cfg(unix)]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::Arc;

use lampyris::geometry::{Mesh, Ray};

unsafe extern "C" {
    fn dlopen(name: *const c_char, flags: c_int) -> *mut c_void;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

/// Newest first.
const LIBRARIES: [(&CStr, Version); 2] =
    [(c"libembree4.so.4", Version::Four), (c"libembree3.so.3", Version::Three)];
/// Resolve all names at once.
const RTLD_NOW: c_int = 2;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Three,
    Four,
}

const VERTEX_BUFFER: c_int = 1;
const INDEX_BUFFER: c_int = 0;
const TRIANGLES: c_int = 0;
const UINT3: c_int = 0x5003;
const FLOAT3: c_int = 0x9003;
const NONE: u32 = u32::MAX;

type Object = *mut c_void;
type NewObject = unsafe extern "C" fn(Object) -> Object;
type NewDevice = unsafe extern "C" fn(*const c_char) -> Object;
type NewGeometry = unsafe extern "C" fn(Object, c_int) -> Object;
type NewBuffer = unsafe extern "C" fn(Object, c_int, u32, c_int, usize, usize) -> *mut c_void;
type Commit = unsafe extern "C" fn(Object);
type Attach = unsafe extern "C" fn(Object, Object) -> u32;
/// Scene, context, ray in version 3; scene, ray, arguments in version 4.
type Intersect = unsafe extern "C" fn(Object, *mut c_void, *mut c_void);

/// Its ray and hit, with room at the end for the fields of later versions.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub struct EmbreeRay {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    weights: [f32; 2],
    primitive: u32,
    geometry: u32,
    instances: [u32; 9],
}

impl EmbreeRay {
    /// `near_mm` keeps a ray off the surface that it leaves, which Embree has no name for.
    pub fn new(ray: &Ray, near_mm: f32) -> EmbreeRay {
        EmbreeRay {
            origin: ray.origin.to_array().map(|x| x as f32),
            near: near_mm,
            direction: ray.direction.to_array().map(|x| x as f32),
            time: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            weights: [0.0; 2],
            primitive: NONE,
            geometry: NONE,
            instances: [NONE; 9],
        }
    }
}

/// What version 3 wants with each call.
#[repr(C)]
struct Context {
    flags: c_int,
    filter: *const c_void,
    instances: [u32; 8],
}

/// A committed scene; it lives until the program ends.
pub struct Embree {
    version: Version,
    scene: Object,
    intersect: Intersect,
}

impl Embree {
    /// `None` if the library is not there.
    pub fn build(meshes: &[Arc<Mesh>]) -> Option<Embree> {
        LIBRARIES.into_iter().find_map(|(name, version)| {
            // SAFETY: a C string; Embree's start-up code has no conditions.
            let library = unsafe { dlopen(name.as_ptr(), RTLD_NOW) };
            // SAFETY: just opened.
            (!library.is_null()).then(|| unsafe { Embree::open(library, version, meshes) })?
        })
    }

    /// # Safety
    /// `library` is Embree's, of that version.
    unsafe fn open(library: Object, version: Version, meshes: &[Arc<Mesh>]) -> Option<Embree> {
        // SAFETY: the types are those of Embree's headers; buffers are filled to the sizes that
        // they were asked for.
        unsafe {
            let new_device: NewDevice = function(library, c"rtcNewDevice")?;
            let new_scene: NewObject = function(library, c"rtcNewScene")?;
            let new_geometry: NewGeometry = function(library, c"rtcNewGeometry")?;
            let new_buffer: NewBuffer = function(library, c"rtcSetNewGeometryBuffer")?;
            let commit_geometry: Commit = function(library, c"rtcCommitGeometry")?;
            let attach: Attach = function(library, c"rtcAttachGeometry")?;
            let commit_scene: Commit = function(library, c"rtcCommitScene")?;
            let device = new_device(std::ptr::null());
            let scene = new_scene(device);
            for mesh in meshes {
                let geometry = new_geometry(device, TRIANGLES);
                let positions: Vec<[f32; 3]> =
                    mesh.positions.iter().map(|p| p.to_array().map(|x| x as f32)).collect();
                for (kind, format, values) in [
                    (VERTEX_BUFFER, FLOAT3, bytes_of(&positions)),
                    (INDEX_BUFFER, UINT3, bytes_of(&mesh.triangles)),
                ] {
                    let place = new_buffer(geometry, kind, 0, format, 12, values.len() / 12);
                    std::ptr::copy_nonoverlapping(values.as_ptr(), place.cast(), values.len());
                }
                commit_geometry(geometry);
                attach(scene, geometry);
            }
            commit_scene(scene);
            Some(Embree { version, scene, intersect: function(library, c"rtcIntersect1")? })
        }
    }

    pub fn hits(&self, ray: &EmbreeRay) -> bool {
        let mut ray = *ray;
        let place = (&raw mut ray).cast();
        // SAFETY: the arguments of that version, with room for its fields.
        unsafe {
            match self.version {
                Version::Three => {
                    let filter = std::ptr::null();
                    let mut context = Context { flags: 0, filter, instances: [NONE; 8] };
                    (self.intersect)(self.scene, (&raw mut context).cast(), place);
                }
                Version::Four => (self.intersect)(self.scene, place, std::ptr::null_mut()),
            }
        }
        ray.geometry != NONE
    }
}

/// # Safety
/// `F` is the function's type.
unsafe fn function<F: Copy>(library: Object, name: &CStr) -> Option<F> {
    // SAFETY: an open library and a C string; a function pointer has the size of any other.
    unsafe {
        let address = dlsym(library, name.as_ptr());
        (!address.is_null()).then(|| std::mem::transmute_copy(&address))
    }
}

/// Of arrays of three 4-byte numbers.
fn bytes_of<T: Copy>(values: &[[T; 3]]) -> &[u8] {
    // SAFETY: f32 and u32 have no padding.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}
