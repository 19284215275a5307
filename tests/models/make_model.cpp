// Writes a model of models.hpp as a binary STL file: make-model gyroid-sphere|sphere OUT.stl CELLS
#include <cstdio>
#include <exception>
#include <string_view>

#include "tests/models/models.hpp"

int main(int argc, char** argv) {
  const std::string_view kind = argc == 4 ? argv[1] : "";
  const int cells = argc == 4 ? std::atoi(argv[3]) : 0;
  if ((kind != "gyroid-sphere" && kind != "sphere") || cells < 2 || cells > 1000) {
    std::fputs("usage: make-model gyroid-sphere|sphere OUT.stl CELLS (2 to 1000)\n", stderr);
    return 64;
  }
  try {
    constexpr double kRadiusMm = 20, kPeriodMm = 10;
    const auto facets = kind == "sphere" ? contourd::models::sphere(kRadiusMm, cells)
                                         : contourd::models::gyroid_sphere(kRadiusMm, kPeriodMm, cells);
    contourd::models::write_binary_stl(argv[2], facets);
    std::printf("%s: %zu facets\n", argv[2], facets.size());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make-model: %s\n", error.what());
    return 73;
  }
}
