//! Collision detection and response between bones and soft tissue.
