//! The scene in which tiles are compared: tiles in a row on a matt table, a lit board behind each, a small lamp above each.
//!
//! ```text
//!                                 o lamp
//!   camera                               |
//!       `-._                             |  board
//!           `-._ 55 deg from normal      |
//!   ------------[=== tile ====]-------------- table
//! ```
//! x to the right, y away from the camera, z up, metres; the tops of the tiles are z = 0. The camera sees the boards in
//! the mirror of the tiles only: glass reflects a tenth or less, so a picture that shows the mirror image well would
//! over-expose what it mirrors. Every tile sees a board of its own, at the same place of its mirror.

use super::camera::Camera;
use super::letters::Letters;
use super::material::{Coat, Cover, Reflector};
use super::paint::{Paint, Pattern};
use super::scene::Scene;
use super::shape::{Quad, Sphere};
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use crate::model::Lambert;
use std::sync::LazyLock;

/// The matt furniture; its colour is the tint of the coat.
static WHITE: Lambert = Lambert { rho: 1.0 };

/// Angle between the line of sight to the middle of the tiles and their normal \[deg\].
pub const VIEW_ANGLE_DEG: f64 = 55.0;

const MM: f64 = 1e-3;
/// A tile [m]: nearly square when seen at 55 deg.
const WIDTH: f64 = 60.0 * MM;
const DEPTH: f64 = 120.0 * MM;
const THICKNESS: f64 = 4.0 * MM;
/// Between two tiles.
const GAP: f64 = 14.0 * MM;
/// From the far edge of the tiles to the boards.
const BEHIND: f64 = 40.0 * MM;
/// A board: narrow enough not to meet its neighbours.
const BOARD: f64 = 78.0 * MM;
/// Radiance of the bright parts of a board and of a lamp [W/(m2 sr)].
const BOARD_RADIANCE: f64 = 10.0;
const LAMP_RADIANCE: f64 = 40.0;
const LAMP_COLOUR: DVec3 = DVec3::new(1.0, 0.93, 0.80);
/// Radiance of the room around [W/(m2 sr)].
const ROOM_RADIANCE: f64 = 0.12;

/// What the tiles mirror.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backdrop {
    /// A coarse and a fine checker, bars of falling width and a lamp: something for every roughness.
    #[default]
    Chart,
    /// Lamps alone, from 10 mm to 3 mm across.
    Lamp,
    /// Bright lines of a grid.
    Grid,
    /// Bright words.
    Text,
}

impl Backdrop {
    /// All of them with their names.
    pub const NAMES: [(&'static str, Backdrop); 4] =
        [("chart", Backdrop::Chart), ("lamp", Backdrop::Lamp), ("grid", Backdrop::Grid), ("text", Backdrop::Text)];

    /// Share of a polished tile that mirrors something darker than the bright parts.
    pub fn dark_share(self) -> f64 {
        match self {
            // A third of the mirror image is bright cells, a few percent are the lamp.
            Backdrop::Chart => 0.85,
            Backdrop::Lamp => 0.995,
            Backdrop::Grid => 0.75,
            Backdrop::Text => 0.96,
        }
    }

    /// What it is, in a few words for a caption.
    pub fn words(self) -> &'static str {
        match self {
            Backdrop::Chart => "lamp and chart",
            Backdrop::Lamp => "lamps",
            Backdrop::Grid => "lit grid",
            Backdrop::Text => "lit text",
        }
    }
}

static SIGN: LazyLock<Letters> =
    LazyLock::new(|| Letters::new(&["GLOSS", "AaBbCcDd", "0123456789", "sharp or blurred"]));

/// Tiles in a row and what they mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    count: usize,
    backdrop: Backdrop,
}

impl Stage {
    /// A stage for `count` tiles.
    ///
    /// # Errors
    /// `Error::Parameter` for fewer than 1 or more than 12 tiles.
    pub fn new(count: usize, backdrop: Backdrop) -> Result<Self> {
        if !(1..=12).contains(&count) {
            return Err(Error::parameter(
                format!("{count} tiles do not fit on the table"),
                "show 1 to 12 tiles in a row",
            ));
        }
        Ok(Stage { count, backdrop })
    }

    /// What the tiles mirror.
    pub fn backdrop(&self) -> Backdrop {
        self.backdrop
    }

    /// Width over height of a picture that shows the tiles well.
    pub fn aspect(&self) -> f64 {
        self.half_width() / (40.0 * MM)
    }

    /// Half the width that the picture shows, at the middle of the tiles.
    fn half_width(&self) -> f64 {
        // The near edge looks a little larger than the middle.
        1.09 * self.row() / 2.0 + 5.0 * MM
    }

    fn row(&self) -> f64 {
        self.count as f64 * (WIDTH + GAP) - GAP
    }

    fn distance(&self) -> f64 {
        560.0 * MM + 140.0 * MM * self.count as f64
    }

    /// Middle of the top of a tile.
    pub fn centre(&self, tile: usize) -> DVec3 {
        let x = -0.5 * self.row() + 0.5 * WIDTH + tile as f64 * (WIDTH + GAP);
        DVec3::new(x, 0.5 * DEPTH, 0.0)
    }

    /// The top face of a tile.
    ///
    /// # Errors
    /// None for a tile of the row.
    pub fn top(&self, tile: usize) -> Result<Quad> {
        let corner = self.centre(tile) - 0.5 * DVec3::new(WIDTH, DEPTH, 0.0);
        Quad::new(corner, WIDTH * DVec3::X, DEPTH * DVec3::Y)
    }

    /// Where the camera stands.
    pub fn eye(&self) -> DVec3 {
        let (sin, cos) = VIEW_ANGLE_DEG.to_radians().sin_cos();
        Self::target() + self.distance() * DVec3::new(0.0, -sin, cos)
    }

    /// What it looks at: a little before the middle, for the front edge in full.
    fn target() -> DVec3 {
        DVec3::new(0.0, 0.46 * DEPTH, 0.0)
    }

    /// The camera for a picture of the given width over height.
    ///
    /// # Errors
    /// `Error::Parameter` if the aspect is not above 0.
    pub fn camera(&self, aspect: f64) -> Result<Camera> {
        let half_height = self.half_width() / aspect;
        let field = 2.0 * (half_height / self.distance()).atan();
        Camera::perspective(self.eye(), Self::target(), DVec3::Z, field, aspect)
    }

    /// Column of the middle of a tile in the picture, from 0 at the left to 1 at the right.
    pub fn column(&self, tile: usize) -> f64 {
        0.5 + 0.5 * self.centre(tile).x / self.half_width()
    }

    /// A point at height `z` in the plane `y` that the camera sees in the mirror of a tile, in the middle of its width.
    fn mirrored(&self, tile: usize, y: f64, z: f64) -> DVec3 {
        let eye = self.eye();
        // The mirror image of the eye, the middle of the tile and the point lie in one plane.
        let share = (y - eye.y) / (self.centre(tile).y - eye.y);
        DVec3::new(self.centre(tile).x * share, y, z)
    }

    /// Centre of the lamp above a tile; its mirror image is near the front edge.
    pub fn lamp(&self, tile: usize) -> DVec3 {
        self.lamp_over(tile, 0.17 * DEPTH)
    }

    /// A lamp whose mirror image is at `y` on the tile.
    fn lamp_over(&self, tile: usize, y: f64) -> DVec3 {
        let (eye, plane) = (self.eye(), DEPTH + 15.0 * MM);
        self.mirrored(tile, plane, eye.z * (plane - y) / (y - eye.y))
    }

    /// The scene with a coat for every tile.
    ///
    /// # Errors
    /// `Error::Parameter` if there are fewer or more coats than tiles.
    pub fn scene<'a>(&self, tiles: &[Coat<'a>]) -> Result<Scene<'a>> {
        if tiles.len() != self.count {
            let what = format!("{} coats for {} tiles", tiles.len(), self.count);
            return Err(Error::parameter(what, "give every tile one coat"));
        }
        let mut scene = Scene::new(DVec3::splat(ROOM_RADIANCE))?;
        let matt = |r, g, b| Cover::Plain(Coat::new(Reflector::Grey(&WHITE), DVec3::new(r, g, b)));
        let table = Quad::new(DVec3::new(-1.5, -1.5, -THICKNESS), 3.0 * DVec3::X, 3.0 * DVec3::Y)?;
        scene.add(table, matt(0.13, 0.17, 0.22));
        for (k, coat) in tiles.iter().enumerate() {
            let top = self.top(k)?;
            scene.add(top, Cover::Plain(*coat));
            let corner = self.centre(k) - 0.5 * DVec3::new(WIDTH, DEPTH, 0.0);
            for (at, along) in
                [(corner, WIDTH * DVec3::X), (corner + WIDTH * DVec3::X, DEPTH * DVec3::Y), (corner, DEPTH * DVec3::Y)]
            {
                scene.add(Quad::new(at, along, -THICKNESS * DVec3::Z)?, matt(0.03, 0.03, 0.03));
            }
            self.light(k, &mut scene)?;
        }
        Ok(scene)
    }

    /// Board and lamps of a tile.
    fn light(&self, tile: usize, scene: &mut Scene<'_>) -> Result<()> {
        let lamp = |scene: &mut Scene<'_>, y: f64, radius: f64, aside: f64| {
            let centre = self.lamp_over(tile, y) + aside * DVec3::X;
            scene.add_emitter(Sphere::new(centre, radius)?, Paint::plain(LAMP_RADIANCE * LAMP_COLOUR)?)
        };
        // Foot, height and width in mm.
        match self.backdrop {
            Backdrop::Chart => {
                self.band(tile, scene, [26.0, 31.0, 77.0], Pattern::Checker { columns: 7, rows: 2 })?;
                self.band(tile, scene, [60.0, 14.0, 72.0], Pattern::Bars { count: 8, ratio: 0.8 })?;
                self.band(tile, scene, [77.0, 13.0, 75.6], Pattern::Checker { columns: 25, rows: 4 })?;
                lamp(scene, 0.17 * DEPTH, 5.0 * MM, 0.0)
            }
            Backdrop::Lamp => {
                lamp(scene, 0.22 * DEPTH, 5.0 * MM, 0.0)?;
                lamp(scene, 0.55 * DEPTH, 3.0 * MM, 12.0 * MM)?;
                lamp(scene, 0.76 * DEPTH, 1.5 * MM, -12.0 * MM)
            }
            Backdrop::Grid => {
                self.band(tile, scene, [20.0, 115.0, 78.0], Pattern::Grid { columns: 8, rows: 12, line: 0.22 })
            }
            Backdrop::Text => {
                let letters: &'static Letters = &SIGN;
                let width = BOARD / MM;
                self.band(tile, scene, [34.0, 1.35 * width / letters.aspect(), width], Pattern::Text(letters))
            }
        }
    }

    /// A lit rectangle on the board of a tile: foot above the table, height and width \[mm\].
    fn band(
        &self,
        tile: usize,
        scene: &mut Scene<'_>,
        [foot, height, width]: [f64; 3],
        pattern: Pattern,
    ) -> Result<()> {
        let (across, up) = (width * MM * DVec3::X, height * MM * DVec3::Z);
        let corner = self.mirrored(tile, DEPTH + BEHIND, foot * MM) - 0.5 * across;
        let bright = BOARD_RADIANCE * DVec3::ONE;
        // X x Z looks towards the camera.
        scene.add_emitter(Quad::new(corner, across, up)?, Paint::new(pattern, bright, 0.002 * bright)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tiles_are_seen_at_the_stated_angle_and_in_the_stated_columns() {
        for count in [1, 2, 4] {
            let stage = Stage::new(count, Backdrop::Chart).unwrap();
            let camera = stage.camera(stage.aspect()).unwrap();
            let cos = -camera.ray(0.5, 0.5).direction.z;
            assert!((cos.acos().to_degrees() - VIEW_ANGLE_DEG).abs() < 1e-9);
            for k in 0..count {
                let ray = camera.ray(stage.column(k), 0.5);
                let t = stage.top(k).unwrap().intersect(&ray, f64::INFINITY).unwrap();
                assert!((ray.at(t).x - stage.centre(k).x).abs() < 1e-9);
            }
        }
        assert!(Stage::new(0, Backdrop::Chart).is_err() && Stage::new(13, Backdrop::Chart).is_err());
    }

    /// The mirror image of the lamp is where it is said to be.
    #[test]
    fn the_lamp_is_mirrored_near_the_front_edge() {
        let stage = Stage::new(3, Backdrop::Chart).unwrap();
        for k in 0..3 {
            let (eye, lamp) = (stage.eye(), stage.lamp(k));
            let image = DVec3::new(lamp.x, lamp.y, -lamp.z);
            let at = eye + (image - eye) * (eye.z / (eye.z - image.z));
            assert!((at.y - 0.17 * DEPTH).abs() < 1e-9, "{at}");
            let x = stage.centre(k).x;
            assert!((at.x - x).abs() < 0.07 * x.abs() + 1e-9, "{at} {x}");
        }
    }
}
