//! People who stand, walk, run, jump and wave, made from a footstep plan, with ground truth.
