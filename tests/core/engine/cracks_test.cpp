// The effect of cracks: good models, damaged as files are, keep their masks except near the damage, and the
// layer's report says what was repaired.
#include <cstdio>
#include <filesystem>

#include "core/engine/contour_engine.hpp"
#include "core/formats/model_reader.hpp"
#include "core/model/placement.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/models/damage.hpp"
#include "tests/random_shapes.hpp"

using models::Dice;
using models::Facets;

namespace {

constexpr double kReachMm = 0.02;  // the distance by which vertices move
constexpr int kColumns = kFineDisplay.width.count(), kRows = kFineDisplay.height.count();

// The distance from a point to the nearest point of a convex polygon, zero within it.
double distance_to(const std::vector<Point>& polygon, double x, double y) {
  bool left = true, right = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double cross = dx * (y - a.y) - dy * (x - a.x);
    left = left && cross >= 0;
    right = right && cross <= 0;
    const double length2 = dx * dx + dy * dy;
    const double s = length2 > 0 ? std::clamp(((x - a.x) * dx + (y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, std::hypot(a.x + s * dx - x, a.y + s * dy - y));
  }
  return (left || right) && polygon.size() > 2 ? 0.0 : nearest;
}

// A facet's part between two heights, seen from above.
std::vector<Point> slab_of(const Facet& facet, double low, double high) {
  using Corner = std::array<double, 3>;
  std::vector<Corner> part;
  for (const Vertex& v : facet.vertices)
    part.push_back({v.x, v.y, v.z});
  for (const double side : {1.0, -1.0}) {
    const double limit = side > 0 ? low : -high;
    std::vector<Corner> kept;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Corner &a = part[i], &b = part[(i + 1) % part.size()];
      const double at_a = side * a[2] - limit, at_b = side * b[2] - limit;
      if (at_a >= 0) kept.push_back(a);
      if ((at_a < 0) != (at_b < 0)) {
        const double s = at_a / (at_a - at_b);
        kept.push_back({a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])});
      }
    }
    part = kept;
  }
  std::vector<Point> seen;
  for (const Corner& corner : part)
    seen.push_back({corner[0], corner[1]});
  return seen;
}

// The pixels that damage may change.
class Zone {
 public:
  explicit Zone(const PixelMap& map) : map_(map), near_(static_cast<std::size_t>(kColumns * kRows), false) {}

  // Adds all pixels within `reach` of the part of the facet that is within `reach` above and below z.
  void add(const Facet& facet, double z, double reach) {
    std::vector<Point> part = slab_of(facet, z - reach, z + reach);
    if (part.empty()) return;
    Bounds box;
    for (Point& p : part) {
      const PixelPoint at = map_.to_pixels(p);
      p = {at.x, at.y};
      box.min_x = std::min(box.min_x, at.x), box.max_x = std::max(box.max_x, at.x);
      box.min_y = std::min(box.min_y, at.y), box.max_y = std::max(box.max_y, at.y);
    }
    // A pixel is within reach if its centre is within reach plus half its diagonal.
    const double far = reach * map_.pixels_per_mm() + std::sqrt(0.5);
    const auto [first_column, last_column] = within(box.min_x - far, box.max_x + far, kColumns);
    const auto [first_row, last_row] = within(box.min_y - far, box.max_y + far, kRows);
    for (int row = first_row; row <= last_row; ++row) {
      for (int column = first_column; column <= last_column; ++column) {
        if (distance_to(part, column + 0.5, row + 0.5) <= far) near_[index_of(row, column)] = true;
      }
    }
  }
  [[nodiscard]] bool has(int row, int column) const { return near_[index_of(row, column)]; }

 private:
  static std::size_t index_of(int row, int column) {
    return static_cast<std::size_t>(row * kColumns + column);
  }
  static std::pair<int, int> within(double low, double high, int size) {
    return {static_cast<int>(std::clamp(low, 0.0, size - 1.0)),
            static_cast<int>(std::clamp(high, 0.0, size - 1.0))};
  }

  PixelMap map_;
  std::vector<bool> near_;
};

// A good model and its damaged copy.
struct Patient {
  Facets whole;
  Facets broken;
  Facets lost;          // facets of `whole` that are missing in `broken`
  double reach_mm = 0;  // how far anything was moved
};

struct Damage {
  const char* name;
  void (*inflict)(Patient& patient, Dice& dice);
};

constexpr double kShareLost = 0.001;
constexpr double kShareSplit = 0.1;

void shake(Patient& patient, Dice& dice) {
  models::shake_corners(patient.broken, kReachMm, dice);
  patient.reach_mm = kReachMm;
}

void lose(Patient& patient, Dice& dice) {
  patient.lost = models::drop_facets(patient.broken, kShareLost, dice);
}

void split(Patient& patient, Dice& dice) {
  models::split_sides(patient.broken, kShareSplit, 0, dice);
}

void split_and_move(Patient& patient, Dice& dice) {
  models::split_sides(patient.broken, kShareSplit, kReachMm, dice);
  patient.reach_mm = kReachMm;
}

void everything(Patient& patient, Dice& dice) {
  lose(patient, dice);
  split(patient, dice);
  shake(patient, dice);
}

constexpr std::array<Damage, 5> kDamages{{{"corners shaken", shake},
                                          {"facets lost", lose},
                                          {"sides split", split},
                                          {"sides split beside their middle", split_and_move},
                                          {"all of it", everything}}};

Patient patient_of(const Facets& whole, const Damage& damage, std::uint64_t seed) {
  Patient patient{whole, whole, {}};
  Dice dice(seed);
  damage.inflict(patient, dice);
  return patient;
}

// Returns the zone in which the mask may differ: the surface moved, at this height, or facets were lost.
Zone zone_of(const Patient& patient, const PixelMap& map, double z) {
  Zone zone(map);
  if (patient.reach_mm > 0) {
    for (const Facet& facet : patient.whole)
      zone.add(facet, z, patient.reach_mm);
  }
  for (const Facet& facet : patient.lost)
    zone.add(facet, z, patient.reach_mm);
  return zone;
}

struct Difference {
  int pixels = 0;       // changed outside the zone
  int longest_run = 0;  // longest run of such pixels in a row
};

// One more rounded height on a side can tip a grey value by one level (see the rasterizer's tests).
constexpr int kTippedLevels = 1;

Difference difference_outside(const Zone& zone, const Mask& intact, const Mask& mask) {
  Difference found;
  for (int row = 0; row < kRows; ++row) {
    const auto was = intact.row(row), is = mask.row(row);
    int run = 0;
    for (int column = 0; column < kColumns; ++column) {
      const auto at = static_cast<std::size_t>(column);
      const bool changed = std::abs(was[at] - is[at]) > kTippedLevels && !zone.has(row, column);
      run = changed ? run + 1 : 0;
      found.pixels += changed;
      found.longest_run = std::max(found.longest_run, run);
    }
  }
  return found;
}

PixelMap map_for(const Facets& facets) {
  return PixelMap::true_scale(kFineDisplay, bounds_of(facets).center());
}

// The mask at z, and its contours with the report of their repairs.
struct CutLayer {
  Mask mask;
  Contours contours;
};

CutLayer layer_of(const HeightIndex& model, const PixelMap& map, double z) {
  ContourEngine engine(model, {kFineDisplay, AntiAliasing::On}, {map});
  CutLayer layer{engine.mask_at_z(Millimeters{z}), {}};
  Section section;
  slice_at(model, Millimeters{z}, section);
  ContourLinker().link(section.segments, engine.join_tolerance(), layer.contours);
  return layer;
}

// Calls check(zone's difference, intact mask, damaged layer, z) at heights away from the model's ends, where
// the damage could do away with the whole section.
template <typename Check>
void at_some_heights(const Patient& patient, int heights, Dice& dice, Check&& check) {
  const PixelMap map = map_for(patient.whole);
  const HeightIndex whole(patient.whole), broken(patient.broken);
  const Bounds& bounds = whole.bounds();
  for (int i = 0; i < heights; ++i) {
    const double z = dice.between(bounds.min_z + 0.1, bounds.max_z - 0.1);
    const CutLayer intact = layer_of(whole, map, z);
    const CutLayer layer = layer_of(broken, map, z);
    check(difference_outside(zone_of(patient, map, z), intact.mask, layer.mask), intact, layer, z);
  }
}

// A box whose faces have many facets.
Facets fine_box() {
  Facets facets = models::box({-8, -7, 0}, {8, 7, 12});
  for (int times = 0; times < 4; ++times) {
    Facets finer;
    for (const auto& [corners] : facets) {
      const auto& [a, b, c] = corners;
      const auto middle = [](const Vertex& p, const Vertex& q) {
        return Vertex{(p.x + q.x) / 2, (p.y + q.y) / 2, (p.z + q.z) / 2};
      };
      const Vertex ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{{a, ab, ca}}, {{ab, b, bc}}, {{ca, bc, c}}, {{ab, bc, ca}}});
    }
    facets = finer;
  }
  return facets;
}

// The holes that lost facets leave in a section: how many, and how wide the widest is if none touches
// another.
struct Holes {
  std::uint32_t count = 0;
  bool apart = true;
  double widest = 0;
};

Holes holes_in(const Facets& lost, double z) {
  Holes holes;
  std::vector<Segment> segments;
  for (const Facet& facet : lost) {
    Section section;
    slice_at(HeightIndex({facet}), Millimeters{z}, section);
    segments.insert(segments.end(), section.segments.begin(), section.segments.end());
  }
  holes.count = static_cast<std::uint32_t>(segments.size());
  for (const Segment& a : segments) {
    holes.widest = std::max(holes.widest, std::hypot(a.to.x - a.from.x, a.to.y - a.from.y));
    for (const Segment& b : segments)
      holes.apart = holes.apart && !(a.to == b.from);
  }
  return holes;
}

}  // namespace

TEST_CASE("A damaged ball's and box's masks differ from the intact ones only where the damage is", "[long]") {
  for (const Facets& whole : {models::sphere(8, 24), fine_box()}) {
    for (const Damage& damage : kDamages) {
      for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Patient patient = patient_of(whole, damage, seed);
        Dice dice(seed + 100);
        at_some_heights(patient, 5, dice,
                        [&](const Difference& difference, const CutLayer&, const CutLayer& layer, double z) {
                          CAPTURE(whole.size(), damage.name, seed, z, layer.contours.cracks.open_chains);
                          CHECK(difference.pixels == 0);
                        });
      }
    }
  }
}

// Some walls turn level, and some facets are smaller than the distance by which their corners move: there the
// ends that belong together cannot always be found.
TEST_CASE("A damaged gyroid's masks hardly differ from the intact ones except where the damage is",
          "[long]") {
  const Facets whole = models::gyroid_sphere(8, 5, 40);
  for (const Damage& damage : kDamages) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Patient patient = patient_of(whole, damage, seed);
      Dice dice(seed + 100);
      at_some_heights(
          patient, 5, dice,
          [&](const Difference& difference, const CutLayer& intact, const CutLayer& layer, double z) {
            CAPTURE(damage.name, seed, z, layer.contours.cracks.open_chains,
                    layer.contours.cracks.widest_gap.count());
            // A gap closed with the wrong neighbour costs the pixels between them, and no row
            // spills.
            CHECK(difference.pixels <= 0.01 * intact.mask.lit_area());
            CHECK(difference.longest_run <= layer.contours.cracks.widest_gap.count() / 0.05 + 2);
          });
    }
  }
}

// At the height of a whole plane of vertices, within the distance by which they have moved, facets are
// crossed at random; a contour continues at the latest at the far end of the next side.
TEST_CASE("No bridge of a shaken lattice is longer than two of its sides") {
  constexpr int kCells = 24;
  constexpr double kRadius = 12, kPeriod = 2;
  const Facets whole = models::gyroid_sphere(kRadius, kPeriod, kCells);
  double longest = 0;
  for (const auto& [corners] : whole) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vertex &a = corners[i], &b = corners[(i + 1) % 3];
      longest = std::max(longest, std::hypot(double{a.x} - b.x, double{a.y} - b.y));
    }
  }
  CHECK(rc::check([&] {
    const auto& damage = testing::draw(0, 1) == 0 ? kDamages.front() : kDamages.back();
    const Patient patient = patient_of(whole, damage, static_cast<std::uint64_t>(testing::draw(0, 1000)));
    const HeightIndex broken(patient.broken);
    // A height around one of the vertices.
    const auto at = static_cast<std::size_t>(testing::draw(0, static_cast<std::int64_t>(whole.size()) - 1));
    const double z = whole[at].vertices[0].z + testing::draw_real(-kReachMm, kReachMm);
    Section section;
    slice_at(broken, Millimeters{z}, section);
    Contours contours;
    ContourLinker().link(section.segments, Millimeters{0.05}, contours);
    RC_ASSERT(contours.cracks.widest_gap.count() <= 2 * longest);
  }));
}

TEST_CASE("Vertices that move alike in all their facets leave nothing to repair") {
  for (const Facets& whole : {models::sphere(8, 24), fine_box(), models::gyroid_sphere(8, 5, 30)}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      Patient patient{whole, whole, {}, kReachMm};
      Dice dice(seed);
      models::shake_vertices(patient.broken, kReachMm, dice);
      at_some_heights(patient, 5, dice,
                      [&](const Difference& difference, const CutLayer&, const CutLayer& layer, double z) {
                        CAPTURE(whole.size(), seed, z);
                        CHECK(difference.pixels == 0);
                        CHECK(layer.contours.cracks.gaps_closed == 0);
                        CHECK(layer.contours.cracks.open_chains == 0);
                        CHECK(layer.contours.cracks.widest_gap == Millimeters{0});
                      });
    }
  }
}

TEST_CASE("The report counts the holes that lost facets leave and measures the widest") {
  std::uint32_t seen = 0;
  for (const Facets& whole : {models::sphere(8, 24), fine_box()}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const Patient patient = patient_of(whole, kDamages[1], seed);
      Dice dice(seed);
      for (const Facet& lost : patient.lost) {
        const Bounds bounds = bounds_of(std::span(&lost, 1));
        const double z = dice.between(bounds.min_z, bounds.max_z);
        const Holes holes = holes_in(patient.lost, z);
        if (!holes.apart || holes.count == 0) continue;
        const Contours contours = layer_of(HeightIndex(patient.broken), map_for(whole), z).contours;
        CAPTURE(whole.size(), seed, z);
        CHECK(contours.cracks.open_chains + contours.cracks.gaps_closed == holes.count);
        CHECK((contours.cracks.open_chains == 0) == (holes.widest <= 0.05));
        CHECK(contours.cracks.widest_gap.count() == testing::Approx(holes.widest).epsilon(1e-9));
        ++seen;
      }
    }
  }
  CHECK(seen > 50);
}

TEST_CASE("The report counts a gap for every cracked side of a box and limits their width") {
  const Facets whole = fine_box();
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const Patient patient = patient_of(whole, kDamages[0], seed);
    Dice dice(seed);
    at_some_heights(patient, 5, dice, [&](const Difference&, const CutLayer&, const CutLayer& layer, double) {
      // A crack at every side that the plane crosses; some are closed together with a segment shorter than
      // they are.
      CHECK(layer.contours.cracks.gaps_closed > 100);
      CHECK(layer.contours.cracks.widest_gap.count() > 0.01);
    });
  }
}

TEST_CASE("A side split at its middle leaves only gaps of rounding, which do not count") {
  int layers = 0;
  for (const Facets& whole : {models::sphere(8, 24), models::gyroid_sphere(8, 5, 30)}) {
    const Patient patient = patient_of(whole, kDamages[2], 7);
    Dice dice(7);
    at_some_heights(patient, 10, dice,
                    [&](const Difference&, const CutLayer&, const CutLayer& layer, double) {
                      CHECK(layer.contours.cracks == LayerCracks{});
                      ++layers;
                    });
  }
  CHECK(layers == 20);
}

TEST_CASE("Damaged real models spill no light", "[long]") {
  const std::filesystem::path folder = std::filesystem::path(CONTOURD_SHARED_DIR) / "models";
  if (!std::filesystem::exists(folder)) {
    std::puts("SKIPPED: the shared models are not there");
    return;
  }
  for (const char* name :
       {"minetto-liver.stl", "minetto-femur.stl", "bunny-closed-70k.stl", "thingi-73416.stl"}) {
    Facets whole = read_model_file(folder / name).facets;
    // Scaled to the display's size.
    const Bounds bounds = bounds_of(whole);
    orient(whole, {0, 0, 0, Scale(16.0 / std::max({bounds.size_x(), bounds.size_y(), bounds.size_z()}))});
    for (const Damage& damage : kDamages) {
      const Patient patient = patient_of(whole, damage, 1);
      Dice dice(1);
      at_some_heights(
          patient, 4, dice,
          [&](const Difference& difference, const CutLayer& intact, const CutLayer& layer, double z) {
            CAPTURE(name, damage.name, z, layer.contours.cracks.open_chains,
                    layer.contours.cracks.widest_gap.count());
            // A hole of millimetres among cracks everywhere may be closed with another wall's ends.
            const double widest_pixels = layer.contours.cracks.widest_gap.count() / 0.05;
            CHECK(difference.pixels <= 0.01 * intact.mask.lit_area() + widest_pixels * widest_pixels);
            CHECK(difference.longest_run <= widest_pixels + 2);
          });
    }
  }
}
