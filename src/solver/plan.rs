//! What runs for a scene.
