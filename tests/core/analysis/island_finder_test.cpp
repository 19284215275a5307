#include "core/analysis/island_finder.hpp"

#include "tests/catch.hpp"
#include "tests/core/text_mask.hpp"
#include "tests/random_shapes.hpp"

namespace {

MaskRuns bright_runs_of(const Mask& mask, std::uint8_t least_grey) {
  MaskRuns bright;
  bright.extract_bright(mask, testing::runs_of(mask), least_grey);
  return bright;
}

std::vector<MaskIsland> islands_of(const Mask& layer, const Mask& beneath, std::uint8_t least_grey,
                                   std::int64_t contact_pixels) {
  IslandFinder finder;
  const auto found =
      finder.find(bright_runs_of(layer, least_grey), bright_runs_of(beneath, least_grey), {contact_pixels, 0})
          .here;
  return {found.begin(), found.end()};
}

// Finds islands with limits at which any lit pixel beneath carries.
std::vector<MaskIsland> islands_of(const Mask& layer, const Mask& beneath) {
  return islands_of(layer, beneath, 1, 1);
}

// The definition of an island, as a reference: floods every group pixel by pixel. Each island as (left, top,
// right, bottom, pixels, grey), sorted.
using IslandFigures =
    std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int32_t, std::int64_t, std::uint64_t>;

class IslandFlood {
 public:
  IslandFlood(const Mask& layer, const Mask& beneath)
      : layer_(layer), beneath_(beneath), seen_(layer.pixels().size()) {}

  std::vector<IslandFigures> islands() {
    std::vector<IslandFigures> found;
    for (std::int32_t y = 0; y < layer_.height().count(); ++y) {
      for (std::int32_t x = 0; x < layer_.width().count(); ++x) {
        held_ = false;
        group_ = {x, y, x + 1, y + 1, 0, 0};
        flood(x, y);
        if (std::get<4>(group_) > 0 && !held_) found.push_back(group_);
      }
    }
    std::ranges::sort(found);
    return found;
  }

 private:
  void flood(std::int32_t x, std::int32_t y) {
    if (x < 0 || y < 0 || x >= layer_.width().count() || y >= layer_.height().count()) return;
    const auto column = static_cast<std::size_t>(x);
    const std::size_t i = static_cast<std::size_t>(y) * layer_.row(0).size() + column;
    if (seen_[i] || layer_.row(y)[column] == 0) return;
    seen_[i] = true;
    held_ = held_ || beneath_.row(y)[column] != 0;
    auto& [left, top, right, bottom, pixels, grey] = group_;
    left = std::min(left, x);
    right = std::max(right, x + 1);
    bottom = std::max(bottom, y + 1);
    ++pixels;
    grey += layer_.row(y)[column];
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx)
        flood(x + dx, y + dy);
    }
  }

  const Mask& layer_;
  const Mask& beneath_;
  std::vector<bool> seen_;
  bool held_ = false;
  IslandFigures group_{};
};

Mask draw_mask(Pixels width, Pixels height, std::int64_t lit_of_ten) {
  Mask mask(width, height);
  for (std::int32_t y = 0; y < height.count(); ++y) {
    for (std::uint8_t& grey : mask.row(y))
      grey = static_cast<std::uint8_t>(draw(1, 10) <= lit_of_ten ? draw(1, 255) : 0);
  }
  return mask;
}

}  // namespace

TEST_CASE("A group with one pixel over a lit one is held, a group beside it is not") {
  const Mask beneath = mask_of({".......", "..#....", "......."});
  CHECK(islands_of(mask_of({".......", "###....", "#......"}), beneath).empty());
  // Neighbours of the lit pixel, but not over it.
  const auto islands = islands_of(mask_of({".......", "...##..", "......."}), beneath);
  REQUIRE(islands.size() == 1);
  CHECK(islands[0].pixels == 2);
}

TEST_CASE("An island has its middle, its box, its pixels and its grey") {
  const auto islands = islands_of(mask_of({"......", "..##..", "..1#..", "......"}),
                                  mask_of({"#.....", "......", "......", "......"}));
  REQUIRE(islands.size() == 1);
  const MaskIsland& island = islands[0];
  CHECK(island.center.x == 3.0);
  CHECK(island.center.y == 2.0);
  CHECK(std::tuple(island.left, island.top, island.right, island.bottom) == std::tuple(2, 1, 4, 3));
  CHECK(island.pixels == 4);
  CHECK(island.grey == 3 * 255 + 55);
}

TEST_CASE("Pixels that touch by a corner are one group") {
  const Mask dark = mask_of({"....", "....", "...."});
  CHECK(islands_of(mask_of({"#..#", ".##.", "...."}), dark).size() == 1);
  CHECK(islands_of(mask_of({"#..#", "....", ".##."}), dark).size() == 3);
}

TEST_CASE("Arms that meet further down are one group, whose box contains all of it") {
  const auto islands = islands_of(mask_of({"#.#.#", "#.#.#", ".#.#.", "....."}), Mask(Pixels{5}, Pixels{4}));
  REQUIRE(islands.size() == 1);
  CHECK(std::tuple(islands[0].left, islands[0].top, islands[0].right, islands[0].bottom) ==
        std::tuple(0, 0, 5, 3));
}

TEST_CASE("The islands found are those of a flood fill") {
  CHECK(rc::check([] {
    const Pixels width{static_cast<std::int32_t>(draw(1, 40))},
        height{static_cast<std::int32_t>(draw(1, 20))};
    const Mask layer = draw_mask(width, height, draw(0, 9)), beneath = draw_mask(width, height, draw(0, 3));
    std::vector<IslandFigures> found;
    for (const MaskIsland& i : islands_of(layer, beneath))
      found.emplace_back(i.left, i.top, i.right, i.bottom, i.pixels, i.grey);
    std::ranges::sort(found);
    RC_ASSERT(found == IslandFlood(layer, beneath).islands());
  }));
}

TEST_CASE("A part that rests only on a faint pixel is an island") {
  const Mask layer = mask_of({"........", ".######.", ".######.", "........"});
  const Mask faint = mask_of({"........", ".000000.", ".000000.", "........"});  // the digits have grey 30
  CHECK(islands_of(layer, faint, 64, 4).size() == 1);
  CHECK(islands_of(layer, faint, 30, 4).empty());
  const Mask one = mask_of({"........", "......1.", "........", "........"});
  CHECK(islands_of(layer, one, 1, 1).empty());
  CHECK(islands_of(layer, one, 64, 1).size() == 1);
}

TEST_CASE("A part that rests only on a corner is an island") {
  const Mask layer = mask_of({"........", ".######.", ".######.", "........"});
  const Mask corner = mask_of({"##......", "##......", "........", "........"});
  CHECK(islands_of(layer, corner, 64, 4).size() == 1);
  CHECK(islands_of(layer, corner, 64, 1).empty());
  const Mask edge = mask_of({"........", "##......", "##......", "........"});
  CHECK(islands_of(layer, edge, 64, 2).empty());
}

TEST_CASE("A thin pin stands on itself") {
  for (const char* const row : {"...#....", "..9#1...", "...2....", "..##...."}) {
    CAPTURE(row);
    const Mask pin = mask_of({"........", row, "........"});
    CHECK(islands_of(pin, pin, 64, 4).empty());
  }
}

namespace {

// Returns the number of islands in each layer but the first; up to two full pixels are a speck.
std::vector<std::size_t> islands_in(const std::vector<std::vector<std::string>>& layers) {
  IslandFinder finder;
  std::vector<std::size_t> counts(layers.size(), 0);
  for (std::size_t i = 1; i < layers.size(); ++i) {
    const auto found = finder.find(bright_runs_of(mask_of(layers[i]), 64),
                                   bright_runs_of(mask_of(layers[i - 1]), 64), {4, 2 * 255});
    counts[i] += found.here.size();
    counts[i - 1] += found.beneath.size();
  }
  return counts;
}

using Counts = std::vector<std::size_t>;

}  // namespace

TEST_CASE("A speck is an island if it continues, and carries or is carried by nothing else") {
  struct Row {
    const char* what;
    std::vector<std::vector<std::string>> layers;
    Counts islands;
  };
  for (const Row& row : {
           Row{"gone in the next layer", {{"####...."}, {"####..#."}, {"####...."}}, {0, 0, 0}},
           Row{"in the last layer", {{"####...."}, {"####..#."}}, {0, 0}},
           Row{"as bright as its limit", {{"####...."}, {"####..##"}, {"####...."}}, {0, 0, 0}},
           Row{"brighter", {{"####....."}, {"####..##4"}, {"####....."}}, {0, 1, 0}},
           Row{"under an island", {{"####......"}, {"####....#."}, {"####..####"}}, {0, 0, 1}},
           Row{"carried by something else", {{"####...."}, {"####..#."}, {"#######."}}, {0, 0, 0}},
           Row{"continuing", {{"####...."}, {"####..#."}, {"####..#."}, {"#######."}}, {0, 1, 0, 0}},
           Row{"growing", {{"####...."}, {"####..#."}, {"####.###"}, {"####.###"}}, {0, 1, 0, 0}},
           Row{"two that grow together", {{"####......"}, {"####..#.#."}, {"####..###."}}, {0, 2, 0}},
           Row{"two that grow together with more",
               {{"####......"}, {"####..#.#."}, {"#########."}},
               {0, 0, 0}},
           Row{"faint at first", {{"####....."}, {"####..0.."}, {"####..##."}, {"####..##."}}, {0, 0, 1, 0}},
           Row{"larger than a speck", {{"####....."}, {"####..###"}, {"#########"}}, {0, 1, 0}},
       }) {
    CAPTURE(row.what);
    CHECK(islands_in(row.layers) == row.islands);
  }
}

TEST_CASE("Faint pixels connect nothing") {
  const Mask standing = mask_of({".###......"}), both = mask_of({".###0####."});
  CHECK(islands_of(both, standing, 64, 4).size() == 1);
  CHECK(islands_of(both, standing, 30, 4).empty());
}

namespace {

// The group number of each pixel, from the top row down; -1 where it is dark.
class Labels {
 public:
  explicit Labels(const Mask& mask) : mask_(mask), of_(mask.pixels().size(), -1) {
    for (std::int32_t y = 0; y < mask.height().count(); ++y) {
      for (std::int32_t x = 0; x < mask.width().count(); ++x)
        groups_ += flood(x, y) ? 1 : 0;
    }
  }

  [[nodiscard]] const std::vector<int>& by_pixel() const { return of_; }
  [[nodiscard]] std::size_t groups() const { return static_cast<std::size_t>(groups_); }

 private:
  bool flood(std::int32_t x, std::int32_t y) {
    if (x < 0 || y < 0 || x >= mask_.width().count() || y >= mask_.height().count()) return false;
    int& label = of_[static_cast<std::size_t>(y * mask_.width().count() + x)];
    if (label >= 0 || mask_.row(y)[static_cast<std::size_t>(x)] == 0) return false;
    label = groups_;
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx)
        (void)flood(x + dx, y + dy);
    }
    return true;
  }

  const Mask& mask_;
  std::vector<int> of_;
  int groups_ = 0;
};

// Counts the second layer's specks that are islands, pixel by pixel by their definition. All lit pixels
// carry.
std::size_t outlasting(const Mask& first, const Mask& second, const Mask& third, std::uint64_t speck_grey) {
  const Labels here(second), above(third);
  std::vector<std::uint64_t> grey(here.groups());
  std::vector<bool> carried(here.groups()), outlasts(here.groups()), carried_by_others(above.groups());
  const std::size_t pixels = second.pixels().size();
  for (std::size_t i = 0; i < pixels; ++i) {
    if (here.by_pixel()[i] < 0) continue;
    const auto group = static_cast<std::size_t>(here.by_pixel()[i]);
    grey[group] += second.pixels()[i];
    if (first.pixels()[i] > 0) carried[group] = true;
  }
  const auto is_speck = [&](std::size_t group) { return !carried[group] && grey[group] <= speck_grey; };
  const auto for_each_shared = [&](auto&& visit) {
    for (std::size_t i = 0; i < pixels; ++i)
      if (here.by_pixel()[i] >= 0 && above.by_pixel()[i] >= 0)
        visit(static_cast<std::size_t>(here.by_pixel()[i]), static_cast<std::size_t>(above.by_pixel()[i]));
  };
  for_each_shared([&](std::size_t under, std::size_t over) {
    if (!is_speck(under)) carried_by_others[over] = true;
  });
  for_each_shared([&](std::size_t under, std::size_t over) {
    if (is_speck(under) && !carried_by_others[over]) outlasts[under] = true;
  });
  return static_cast<std::size_t>(std::ranges::count(outlasts, true));
}

}  // namespace

TEST_CASE("The specks found to be islands are those of the definition") {
  CHECK(rc::check([] {
    const Pixels width{static_cast<std::int32_t>(draw(1, 30))},
        height{static_cast<std::int32_t>(draw(1, 12))};
    const std::int64_t lit = draw(0, 6);
    const Mask first = draw_mask(width, height, draw(0, 3)), second = draw_mask(width, height, lit),
               third = draw_mask(width, height, draw(0, 9));
    const auto speck_grey = static_cast<std::uint64_t>(draw(0, 900));
    IslandFinder finder;
    (void)finder.find(bright_runs_of(second, 1), bright_runs_of(first, 1), {1, speck_grey});
    const auto found = finder.find(bright_runs_of(third, 1), bright_runs_of(second, 1), {1, speck_grey});
    RC_ASSERT(found.beneath.size() == outlasting(first, second, third, speck_grey));
  }));
}
