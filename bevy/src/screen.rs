//! Errors in pixels of a screen, and the distances at which they show.

/// Screen and camera for which levels are made.
///
/// In the middle of a perspective view, an error of `e` at distance `d` takes
/// `e * height / (2 d tan(field_of_view / 2))` pixels. The default is Bevy's camera on a screen of 1080 lines.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Screen {
    /// Vertical field of view, in radians.
    pub field_of_view: f32,
    /// Height of the screen, in pixels.
    pub height: f32,
    /// Largest error of a level on the screen, in pixels.
    pub error: f32,
}

impl Default for Screen {
    fn default() -> Self {
        Self { field_of_view: std::f32::consts::FRAC_PI_4, height: 1080.0, error: 1.0 }
    }
}

impl Screen {
    /// Returns the least distance at which an error shows with at most [`Screen::error`] pixels.
    ///
    /// ```
    /// use neural_mesh_bevy::Screen;
    /// let screen = Screen::default();
    /// // A millimetre is a pixel at 1.3 m.
    /// assert_eq!((screen.distance_of(0.001) * 10.0).round(), 13.0);
    /// assert_eq!(screen.distance_of(screen.error_at(50.0)), 50.0);
    /// ```
    pub fn distance_of(&self, error: f64) -> f32 {
        (error / self.error_at_unit_distance()) as f32
    }

    /// Returns the error, in world units, that shows with [`Screen::error`] pixels at a distance.
    ///
    /// Levels for given distances are made by the errors at these.
    pub fn error_at(&self, distance: f32) -> f64 {
        f64::from(distance) * self.error_at_unit_distance()
    }

    fn error_at_unit_distance(&self) -> f64 {
        let half_view = 0.5 * f64::from(self.field_of_view);
        2.0 * half_view.tan() * f64::from(self.error) / f64::from(self.height)
    }
}
