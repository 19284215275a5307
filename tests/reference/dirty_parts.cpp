#include "tests/reference/dirty_parts.hpp"

namespace contourd::reference {
namespace {

using models::Dice;
using models::Facets;

void add(Facets& facets, Facets more, float x, float y, float z) {
  models::translate(more, x, y, z);
  facets.insert(facets.end(), more.begin(), more.end());
}

// A ball with a cavity, and a ball in that.
Facets nested() {
  Facets facets = models::sphere(14, 24), cavity = models::sphere(10, 20);
  models::invert(cavity);
  add(facets, cavity, 0, 0, 0);
  add(facets, models::sphere(6, 16), 0, 0, 0);
  return facets;
}

// Separate solids that do not touch.
Facets apart() {
  Facets facets = models::globe(5, 24, 36);
  add(facets, models::globe(5, 24, 36), 12, 0, 1);
  add(facets, models::cone(5, 12, 60), 0, 12, 0);
  return facets;
}

// A lathe part with a groove all around and a hole in its foot.
Facets spindle() {
  const std::vector<Point> profile{{0, 4}, {3, 4},  {3, 0},   {9, 0},   {9, 6},
                                   {6, 6}, {6, 12}, {12, 12}, {12, 20}, {0, 20}};
  return models::lathe(profile, 180);
}

// Boxes at every place of a grid, or at every other one, so that they share walls or edges.
Facets boxes(int step) {
  Facets facets;
  for (int i = 0; i < 64; ++i) {
    const auto at = [](int place) { return 5.F * static_cast<float>(place); };
    const int x = i % 4, y = i / 4 % 4, z = i / 16;
    if ((x + y + z) % step == 0) add(facets, models::box({0, 0, 0}, {5, 5, 5}), at(x), at(y), at(z));
  }
  return facets;
}

}  // namespace

std::vector<Part> clean_parts() {
  return {{"ball", models::sphere(14, 40)},
          {"gyroid", models::gyroid_sphere(14, 7, 36)},
          {"nested balls", nested()},
          {"parts apart", apart()},
          {"spindle", spindle()},
          {"boxes edge to edge", boxes(2), true},
          {"boxes wall to wall", boxes(1), true}};
}

std::vector<Dirt> all_dirt() {
  const auto turned = [](double share) {
    return [share](Facets& facets, Dice& dice) { models::turn_facets(facets, share, dice); };
  };
  // A thousandth allows for the rounding of greys and the limited resolution of 64 lines a pixel.
  return {{"clean", 0.999, false, false, [](Facets&, Dice&) {}},
          {"1 % turned", 0.999, false, false, turned(0.01)},
          {"10 % turned", 0.999, false, false, turned(0.1)},
          {"50 % turned", 0.999, false, true, turned(0.5)},
          {"10 % doubled", 0.999, false, false,
           [](Facets& facets, Dice& dice) { models::double_facets(facets, 0.1, dice); }},
          {"5 % doubled, reversed", 0.999, false, false,
           [](Facets& facets, Dice& dice) { models::double_facets_reversed(facets, 0.05, dice); }},
          {"turned, doubled and reversed", 0.999, false, true,
           [](Facets& facets, Dice& dice) {
             models::turn_facets(facets, 0.2, dice);
             models::double_facets(facets, 0.1, dice);
             models::double_facets_reversed(facets, 0.05, dice);
           }},
          {"double-sided", 0.999, false, false,
           [](Facets& facets, Dice&) {
             Facets other = facets;
             models::invert(other);
             facets.insert(facets.end(), other.begin(), other.end());
           }},
          {"5 % deleted", 0.99, true, false,
           [](Facets& facets, Dice& dice) { models::drop_facets(facets, 0.05, dice); }},
          {"20 % turned, 2 % deleted", 0.99, true, false,
           [](Facets& facets, Dice& dice) {
             models::turn_facets(facets, 0.2, dice);
             models::drop_facets(facets, 0.02, dice);
           }},
          // A tenth of a pixel at each edge is two hundredths of a thin strut.
          {"shaken by 5 um", 0.98, true, false,
           [](Facets& facets, Dice& dice) { models::shake_corners(facets, 0.005, dice); }}};
}

}  // namespace contourd::reference
