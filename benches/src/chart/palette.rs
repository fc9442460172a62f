//! Colors that differ for any color vision: the palette of M. Okabe and K. Ito.

/// Black.
pub const BLACK: u32 = 0x00_00_00;
/// Gray, beside the palette.
pub const GRAY: u32 = 0x80_80_80;
/// Blue.
pub const BLUE: u32 = 0x00_72_b2;
/// Sky blue.
pub const SKY: u32 = 0x56_b4_e9;
/// Bluish green.
pub const GREEN: u32 = 0x00_9e_73;
/// Orange.
pub const ORANGE: u32 = 0xe6_9f_00;
/// Vermilion.
pub const VERMILION: u32 = 0xd5_5e_00;
/// Reddish purple.
pub const PURPLE: u32 = 0xcc_79_a7;
