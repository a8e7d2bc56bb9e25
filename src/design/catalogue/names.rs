//! The names of the catalogue as words of the design file; a test compares them with the files.

use nailnoise_quantities::choice;

choice! {
    /// Wood of the workpiece by name; `nailnoise list woods` has the values.
    Species {
        /// A wood without a name: all keys of the wood are given.
        Own = "own",
        /// Pine of the published tests.
        Pine = "pine",
        /// Douglas-fir of the published tests.
        DouglasFir = "Douglas-fir",
        /// Douglas-fir at 15 % moisture, as lumber is built in.
        DouglasFirLumber = "Douglas-fir lumber",
        /// Poplar of the published tests.
        Poplar = "poplar",
        /// Sitka spruce.
        Spruce = "spruce",
        /// Northern red oak.
        RedOak = "red oak",
        /// Plywood of Douglas-fir of the published tests.
        DouglasFirPlywood = "Douglas-fir plywood",
        /// Canadian softwood plywood of the published tests.
        CanadianSoftwoodPlywood = "Canadian softwood plywood",
        /// Plywood of poplar of the published tests.
        PoplarPlywood = "poplar plywood",
    }
}

choice! {
    /// Build of the worktable by name; `nailnoise list tables` has the values.
    WorktablePreset {
        /// A table without a name: all keys of its build are given.
        Own = "own",
        /// A: a plywood top on four legs of solid wood.
        A = "A",
        /// B: a thin steel top on four steel tubes.
        B = "B",
        /// C: a thick steel top on the same tubes.
        C = "C",
    }
}

choice! {
    /// Nail by size and shank; `nailnoise list nails` has the values.
    NailKind {
        /// A nail without a name: all its dimensions are given.
        Own = "own",
        /// 31.75 mm long, smooth shank.
        Smooth3D = "3d smooth",
        /// 38.1 mm long, smooth shank.
        Smooth4D = "4d smooth",
        /// 50.8 mm long, smooth shank.
        Smooth6D = "6d smooth",
        /// 63.5 mm long, smooth shank.
        Smooth8D = "8d smooth",
        /// 76.2 mm long, smooth shank.
        Smooth10D = "10d smooth",
        /// 82.55 mm long, smooth shank.
        Smooth12D = "12d smooth",
        /// 88.9 mm long, smooth shank.
        Smooth16D = "16d smooth",
        /// 31.75 mm long, annular rings.
        Annular3D = "3d annular",
        /// 38.1 mm long, annular rings.
        Annular4D = "4d annular",
        /// 50.8 mm long, annular rings.
        Annular6D = "6d annular",
        /// 63.5 mm long, annular rings.
        Annular8D = "8d annular",
        /// 76.2 mm long, annular rings.
        Annular10D = "10d annular",
        /// 82.55 mm long, annular rings.
        Annular12D = "12d annular",
        /// 88.9 mm long, annular rings.
        Annular16D = "16d annular",
        /// 63.5 mm long, helical thread.
        Helical8D = "8d helical",
        /// 76.2 mm long, helical thread.
        Helical10D = "10d helical",
        /// 82.55 mm long, helical thread.
        Helical12D = "12d helical",
        /// 88.9 mm long, helical thread.
        Helical16D = "16d helical",
        /// 25 mm long brad of 18 gauge, from a stick.
        Brad18Ga25 = "18ga brad 25",
        /// 50 mm long brad of 18 gauge, from a stick.
        Brad18Ga50 = "18ga brad 50",
        /// 38 mm long finish nail of 16 gauge, from a stick.
        Finish16Ga38 = "16ga finish 38",
        /// 50 mm long finish nail of 16 gauge, from a stick.
        Finish16Ga50 = "16ga finish 50",
        /// 64 mm long finish nail of 16 gauge, from a stick.
        Finish16Ga64 = "16ga finish 64",
        /// 50 mm long finish nail of 15 gauge, from a stick.
        Finish15Ga50 = "15ga finish 50",
        /// 64 mm long finish nail of 15 gauge, from a stick.
        Finish15Ga64 = "15ga finish 64",
        /// 50 mm long nail with a T head of 14 gauge, from a stick.
        TNail14Ga50 = "14ga T nail 50",
        /// Staple of 18 gauge with a narrow crown of 1/4 in and legs of 25 mm, from a stick.
        Staple18Ga25 = "18ga staple 25",
        /// Staple of 16 gauge with a medium crown of 7/16 in and legs of 38 mm, from a stick.
        Staple16Ga38 = "16ga staple 38",
        /// Staple of 16 gauge with a medium crown of 7/16 in and legs of 50 mm, from a stick.
        Staple16Ga50 = "16ga staple 50",
        /// 32 mm long roofing nail of 11 gauge, from a coil.
        Roofing11Ga32 = "11ga roofing 32",
        /// 44 mm long roofing nail of 11 gauge, from a coil.
        Roofing11Ga44 = "11ga roofing 44",
        /// 57 mm long nail of 12.5 gauge with annular rings, from a coil.
        Ring12Ga57 = "12.5ga ring 57",
        /// 57 mm long nail of 12.5 gauge with a helical thread, from a coil.
        Screw12Ga57 = "12.5ga screw 57",
        /// 83 mm long smooth framing nail of 0.131 in, from a stick.
        Strip10Ga83 = "10.25ga strip 83",
    }
}
