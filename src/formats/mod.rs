//! Motion files as text: BVH, ASF and AMC, bytes in, motion and notices out. Opens no file.
