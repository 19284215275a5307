#include "core/mask/mask_runs.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

bool same_run(const PixelRun& a, const PixelRun& b) {
  return a.row == b.row && a.first == b.first && a.end == b.end && a.grey == b.grey;
}

std::vector<PixelRun> pixel_by_pixel(const Mask& mask) {
  std::vector<PixelRun> runs;
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    bool lit = false;
    for (std::int32_t x = 0; x < mask.width().count(); ++x) {
      const std::uint8_t grey = mask.row(y)[static_cast<std::size_t>(x)];
      if (grey != 0 && !lit) runs.push_back({y, x, x, 0});
      lit = grey != 0;
      if (!lit) continue;
      ++runs.back().end;
      runs.back().grey += grey;
    }
  }
  return runs;
}

}  // namespace

TEST_CASE("A dark mask has no runs, and a fully lit one has one in each row") {
  Mask mask(Pixels{100}, Pixels{3});
  MaskRuns runs;
  runs.extract(mask);
  CHECK(runs.runs().empty());
  CHECK(runs.grey_sum() == 0);
  CHECK(runs.rows() == 3);
  for (std::int32_t y = 0; y < 3; ++y)
    std::ranges::fill(mask.row(y), std::uint8_t{255});
  runs.extract(mask);
  REQUIRE(runs.runs().size() == 3);
  CHECK(same_run(runs.runs()[1], {1, 0, 100, 25500}));
  CHECK(runs.in_row(2).size() == 1);
  CHECK(runs.first_in_row(2) == 2);
  CHECK(runs.grey_sum() == 3 * 25500);
}

TEST_CASE("Runs equal those found pixel by pixel, at any width and place") {
  CHECK(rc::check([] {
    Mask mask(Pixels{static_cast<std::int32_t>(draw(1, 200))}, Pixels{static_cast<std::int32_t>(draw(1, 4))});
    for (std::int32_t y = 0; y < mask.height().count(); ++y) {
      const std::span<std::uint8_t> row = mask.row(y);
      // Stretches of dark, fully lit and grey pixels, so that every path through the words is taken.
      for (std::size_t x = 0; x < row.size();) {
        const auto kind = draw(0, 2);
        for (auto left = draw(1, 40); left > 0 && x < row.size(); --left)
          row[x++] = static_cast<std::uint8_t>(kind == 0 ? 0 : kind == 1 ? 255 : draw(1, 255));
      }
    }
    MaskRuns runs;
    runs.extract(mask);
    const std::vector<PixelRun> expected = pixel_by_pixel(mask);
    RC_ASSERT(std::ranges::equal(runs.runs(), expected, same_run));
    RC_ASSERT(runs.grey_sum() ==
              std::accumulate(mask.pixels().begin(), mask.pixels().end(), std::uint64_t{0}));
    for (std::int32_t y = 0; y < mask.height().count(); ++y) {
      RC_ASSERT(std::ranges::all_of(runs.in_row(y), [y](const PixelRun& run) { return run.row == y; }));
    }
  }));
}
