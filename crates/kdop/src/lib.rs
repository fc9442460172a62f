//! Discrete oriented polytopes and quadtrees of them for deforming leaves.
