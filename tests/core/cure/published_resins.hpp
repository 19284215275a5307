// Working curves of resins as papers and data sheets give them.
#pragma once

#include <array>

struct PublishedResin {
  const char* name;
  double depth_um, dose;  // Dp, and Ec in mJ/cm2
};

// Measured by NIST at 405 nm and at 385 or 365 nm (Bennett 2017, and the round robin of one procedure), by
// Liqcreate at 405 and 385 nm, and, the last three, of a slicer's profiles.
inline constexpr std::array kPublishedResins{PublishedResin{"PR48, 405 nm", 53, 6.3},
                                             PublishedResin{"PR48, 365 nm", 42, 18.3},
                                             PublishedResin{"PR48, round robin, 405 nm", 69.3, 17.9},
                                             PublishedResin{"PR48, round robin, 385 nm", 39.2, 12.3},
                                             PublishedResin{"Formlabs Clear, 405 nm", 192, 12.6},
                                             PublishedResin{"Formlabs Clear, 365 nm", 146, 5.2},
                                             PublishedResin{"VeroClear, 405 nm", 568, 6.9},
                                             PublishedResin{"VeroClear, 365 nm", 186, 2.1},
                                             PublishedResin{"VeroWhite, 405 nm", 145, 1.9},
                                             PublishedResin{"VeroWhite, 365 nm", 43, 0.7},
                                             PublishedResin{"TangoBlack, 405 nm", 151, 4.1},
                                             PublishedResin{"TangoBlack, 365 nm", 95, 2.4},
                                             PublishedResin{"Premium Black, 405 nm", 170, 5.0},
                                             PublishedResin{"Premium Black, 385 nm", 90, 2.5},
                                             PublishedResin{"Premium White, 405 nm", 350, 6.9},
                                             PublishedResin{"Premium White, 385 nm", 80, 3.8},
                                             PublishedResin{"Premium Tough, 405 nm", 560, 14.5},
                                             PublishedResin{"Premium Tough, 385 nm", 120, 7.2},
                                             PublishedResin{"Clear Impact, 405 nm", 170, 14},
                                             PublishedResin{"Clear Impact, 385 nm", 80, 6.5},
                                             PublishedResin{"Strong-X, 405 nm", 200, 9.9},
                                             PublishedResin{"Strong-X, 385 nm", 90, 9.6},
                                             PublishedResin{"Tough-X, 405 nm", 270, 24.2},
                                             PublishedResin{"Tough-X, 385 nm", 140, 22.2},
                                             PublishedResin{"Composite-X, 405 nm", 180, 9.6},
                                             PublishedResin{"Composite-X, 385 nm", 110, 14.3},
                                             PublishedResin{"Standard Clear", 82.7, 1.47},
                                             PublishedResin{"ABS-like Clear", 135.6, 6.83},
                                             PublishedResin{"Speed Gray", 122.8, 1.29}};
