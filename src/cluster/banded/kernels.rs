//! The inner loops of the banded tree, compiled for the widest registers that the processor has.
//!
//! The only place in this room with `unsafe`. Each loop is written once, over a trait of what differs between
//! registers ([`Registers`]), and compiled for AVX-512, for AVX2 and for whatever the target has anyway (on aarch64: NEON).
//! Filters in f32 may differ in their last bits from one to the other; E is computed by the plain loop of
//! [`error_m2`], which no compiler may reorder, and has the same bits on all of them.

use super::super::metric::{Vector, error_m2};
use super::band::Source;
use super::join::{self, Groups, HalfRows, Limit};
use super::point_tree::{Pile, PointTree, Query};

/// Floats that are handled at once: sixteen points in one direction, or one point in sixteen.
pub(super) const WIDTH: usize = 16;

/// Sixteen floats on a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Floats(pub(super) [f32; WIDTH]);

/// Which registers a loop runs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    /// What every processor of the target has.
    Plain,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// All that this processor has, narrowest first.
    pub(super) fn all() -> Vec<Level> {
        let mut levels = vec![Level::Plain];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") {
                levels.push(Level::Avx2);
                if has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") {
                    levels.push(Level::Avx512);
                }
            }
        }
        levels
    }
}

/// What registers do differently.
pub(super) trait Registers {
    /// a * b + c, fused where that is one instruction.
    fn fused(a: f32, b: f32, c: f32) -> f32;
    /// Says that a value will be read soon.
    fn prefetch<T>(value: &T);
    /// Bit l: whether value l is at most the limit. A NaN is not.
    fn at_most(values: &Floats, limit: f32) -> u32;
}

struct Plain;

impl Registers for Plain {
    #[inline(always)]
    fn fused(a: f32, b: f32, c: f32) -> f32 {
        a * b + c
    }

    #[inline(always)]
    fn prefetch<T>(_: &T) {}

    #[inline(always)]
    fn at_most(values: &Floats, limit: f32) -> u32 {
        values.0.iter().enumerate().fold(0, |bits, (lane, &value)| bits | u32::from(value <= limit) << lane)
    }
}

#[cfg(target_arch = "x86_64")]
struct Avx2;

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "reading registers' comparisons as bits")]
impl Registers for Avx2 {
    #[inline(always)]
    fn fused(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }

    #[inline(always)]
    fn prefetch<T>(value: &T) {
        prefetch_lines(value);
    }

    #[inline(always)]
    fn at_most(values: &Floats, limit: f32) -> u32 {
        use std::arch::x86_64::{_CMP_LE_OQ, _mm256_cmp_ps, _mm256_load_ps, _mm256_movemask_ps, _mm256_set1_ps};
        let (low, high) = values.0.split_at(8);
        // SAFETY: both halves hold eight floats and are aligned to 32 bytes, as `Floats` is to 64. The type is named
        // only below, in functions that enable AVX2 and are called where it was detected.
        unsafe {
            let limit = _mm256_set1_ps(limit);
            let bits = |half: &[f32]| {
                _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(_mm256_load_ps(half.as_ptr()), limit)) as u32
            };
            bits(low) | bits(high) << 8
        }
    }
}

#[cfg(target_arch = "x86_64")]
struct Avx512;

#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "reading registers' comparisons as bits")]
impl Registers for Avx512 {
    #[inline(always)]
    fn fused(a: f32, b: f32, c: f32) -> f32 {
        a.mul_add(b, c)
    }

    #[inline(always)]
    fn prefetch<T>(value: &T) {
        prefetch_lines(value);
    }

    #[inline(always)]
    fn at_most(values: &Floats, limit: f32) -> u32 {
        use std::arch::x86_64::{_CMP_LE_OQ, _mm512_cmp_ps_mask, _mm512_load_ps, _mm512_set1_ps};
        // SAFETY: sixteen floats, aligned to 64 bytes. The type is named only below, in functions that enable AVX-512
        // and are called where it was detected.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(_mm512_load_ps(values.0.as_ptr()), _mm512_set1_ps(limit)) })
    }
}

/// Says of every cache line of a value that it will be read soon.
#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "a hint to the processor")]
#[inline(always)]
fn prefetch_lines<T>(value: &T) {
    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    let first = std::ptr::from_ref(value).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64) {
        // SAFETY: a hint, which reads nothing and may name any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(line * 64)) };
    }
}

/// Compiles `body` for all registers; the function made calls the one for its first argument, a [`Level`].
macro_rules! on_each {
    ($(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? = $($body:ident)::+) => {
        $(#[$doc])*
        #[cfg_attr(target_arch = "x86_64", expect(unsafe_code, reason = "calls into code for features that were detected"))]
        pub(super) fn $name(level: Level, $($argument: $type),*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma")]
            fn avx2($($argument: $type),*) $(-> $result)? {
                $($body)::+::<Avx2>($($argument),*)
            }
            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,fma,avx512f,avx512dq,avx512vl,avx512bw")]
            fn avx512($($argument: $type),*) $(-> $result)? {
                $($body)::+::<Avx512>($($argument),*)
            }
            match level {
                Level::Plain => $($body)::+::<Plain>($($argument),*),
                // SAFETY: `Level::all` gives this level only where the processor has every feature enabled above.
                #[cfg(target_arch = "x86_64")]
                Level::Avx2 => unsafe { avx2($($argument),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                Level::Avx512 => unsafe { avx512($($argument),*) },
            }
        }
    };
}

on_each! {
    /// Rows of the half graph: see [`join::rows_of_group`].
    fn rows_of_group(groups: &Groups<'_>, first: usize, limit: Limit, rows: &mut HalfRows) = join::rows_of_group
}

on_each! {
    /// Slots of the tree within a limit of a query: see [`PointTree::within`].
    fn within(tree: &PointTree, vectors: &[Vector], query: &Query<'_>, limit: Limit, found: &mut Vec<u32>)
        = join::within
}

on_each! {
    /// Places in a pile within a limit of a query.
    fn within_pile(pile: &Pile, query: &Query<'_>, limit: Limit, found: &mut Vec<u32>) = join::within_pile
}

on_each! {
    /// E between one vector and each of others.
    fn errors(from: &Vector, by_slot: &[Vector], means: &[Vector], others: &[Source], errors: &mut Vec<f64>) = errors_of
}

/// Vectors that are on their way while one is compared.
pub(super) const AHEAD: usize = 6;

#[inline(always)]
fn errors_of<R: Registers>(
    from: &Vector,
    by_slot: &[Vector],
    means: &[Vector],
    others: &[Source],
    errors: &mut Vec<f64>,
) {
    errors.clear();
    for (at, other) in others.iter().enumerate() {
        if let Some(later) = others.get(at + AHEAD) {
            R::prefetch(later.vector(by_slot, means));
        }
        errors.push(error_m2(from, other.vector(by_slot, means)));
    }
}
