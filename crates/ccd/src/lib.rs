//! Certified continuous collision detection of moving vertices, edges and faces.
