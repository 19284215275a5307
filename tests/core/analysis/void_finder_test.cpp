#include "core/analysis/void_finder.hpp"

#include "tests/catch.hpp"
#include "tests/core/text_mask.hpp"
#include "tests/random_shapes.hpp"

namespace {

using Rows = std::vector<std::string>;

constexpr Nanometers kVoidLayer{100};

std::vector<MaskVoid> voids_of(const std::vector<Mask>& layers) {
  VoidFinder finder;
  std::vector<MaskVoid> all;
  for (std::int32_t number = 0; const Mask& mask : layers) {
    const auto ended = finder.add_layer(testing::runs_of(mask), {number++, kVoidLayer});
    all.insert(all.end(), ended.begin(), ended.end());
  }
  const auto ended = finder.end();
  all.insert(all.end(), ended.begin(), ended.end());
  return all;
}

std::vector<MaskVoid> voids_of(const std::vector<Rows>& layers) {
  std::vector<Mask> masks;
  for (const Rows& rows : layers)
    masks.push_back(mask_of(rows));
  return voids_of(masks);
}

const Rows kFull = {".....", ".###.", ".###.", ".###.", "....."};
const Rows kRing = {".....", ".###.", ".#.#.", ".###.", "....."};
const Rows kOpenRing = {".....", ".#.#.", ".#.#.", ".###.", "....."};
const Rows kNothing = {".....", ".....", ".....", ".....", "....."};

// First, last and widest layer, pixels in the widest layer, volume, on the plate, closed.
using VoidFigures =
    std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int64_t, std::int64_t, bool, bool>;

VoidFigures figures_of(const MaskVoid& v) {
  return {v.first_layer, v.last_layer, v.widest_layer, v.widest_pixels, v.volume, v.on_plate, v.closed};
}

// The definition of a void, as a reference: after each layer, floods the region of all layers so far that is
// not reached from outside, voxel by voxel.
class VoidFlood {
 public:
  explicit VoidFlood(const std::vector<Mask>& layers)
      : layers_(layers),
        width_(static_cast<std::size_t>(layers[0].width().count())),
        height_(static_cast<std::size_t>(layers[0].height().count())) {}

  std::vector<VoidFigures> voids() {
    std::vector<VoidFigures> found;
    for (std::size_t top = 0; top < layers_.size(); ++top) {
      label(top);
      note_sucking(top);
      for (const Sucking& each : sucking_) {
        if (each.layer + 1 != top) continue;
        const int label = labels_[each.voxel];
        // The void is still there and reaches the newest layer: it continues.
        if (label > 1 && is_on(top, label)) continue;
        found.push_back(ended(each, label > 1));
      }
    }
    for (const Sucking& each : sucking_) {
      if (each.layer + 1 == layers_.size()) found.push_back(ended(each, false));
    }
    std::ranges::sort(found);
    return found;
  }

 private:
  // A void as it was when `layer` was the newest one.
  struct Sucking {
    std::size_t layer, voxel;
    std::vector<std::size_t> voxels;
    std::int64_t pixels;  // pixels of the void on that layer
  };

  [[nodiscard]] std::size_t layer_of(std::size_t voxel) const { return voxel / (width_ * height_); }

  // Labels: 0: solid, or not printed yet; 1: outside; from 2 on: a void.
  void label(std::size_t top) {
    labels_.assign(width_ * height_ * layers_.size(), 0);
    count_ = 1;
    for (std::size_t at = 0; at < width_ * height_ * (top + 1); ++at) {
      const std::size_t x = at % width_, y = at / width_ % height_;
      if (x == 0 || y == 0 || x + 1 == width_ || y + 1 == height_) flood(at, top, 1);
    }
    for (std::size_t at = 0; at < width_ * height_ * (top + 1); ++at) {
      if (flood(at, top, count_ + 1)) ++count_;
    }
  }

  bool flood(std::size_t from, std::size_t top, int label) {
    std::vector<std::size_t> todo = {from};
    bool any = false;
    while (!todo.empty()) {
      const std::size_t at = todo.back();
      todo.pop_back();
      const std::size_t x = at % width_, y = at / width_ % height_, layer = layer_of(at);
      if (layer > top || labels_[at] != 0) continue;
      if (layers_[layer].row(static_cast<std::int32_t>(y))[x] != 0) continue;
      labels_[at] = label;
      any = true;
      if (x > 0) todo.push_back(at - 1);
      if (x + 1 < width_) todo.push_back(at + 1);
      if (y > 0) todo.push_back(at - width_);
      if (y + 1 < height_) todo.push_back(at + width_);
      if (layer > 0) todo.push_back(at - width_ * height_);
      todo.push_back(at + width_ * height_);
    }
    return any;
  }

  [[nodiscard]] bool is_on(std::size_t layer, int label) const {
    const auto first = labels_.begin() + static_cast<std::ptrdiff_t>(layer * width_ * height_);
    return std::find(first, first + static_cast<std::ptrdiff_t>(width_ * height_), label) !=
           first + static_cast<std::ptrdiff_t>(width_ * height_);
  }

  void note_sucking(std::size_t top) {
    for (int label = 2; label <= count_; ++label) {
      if (!is_on(top, label)) continue;
      Sucking sucking{top, 0, {}, 0};
      for (std::size_t at = 0; at < labels_.size(); ++at) {
        if (labels_[at] != label) continue;
        sucking.voxel = at;
        sucking.voxels.push_back(at);
        if (layer_of(at) == top) ++sucking.pixels;
      }
      sucking_.push_back(std::move(sucking));
    }
  }

  // Returns the figures of an ended void, which includes everything that sucked before and became part of it.
  [[nodiscard]] VoidFigures ended(const Sucking& last, bool closed) const {
    VoidFigures figures{static_cast<std::int32_t>(layer_of(last.voxels.front())),
                        static_cast<std::int32_t>(last.layer),
                        0,
                        0,
                        static_cast<std::int64_t>(last.voxels.size()) * kVoidLayer.count(),
                        layer_of(last.voxels.front()) == 0,
                        closed};
    for (const Sucking& each : sucking_) {
      if (!std::ranges::binary_search(last.voxels, each.voxel) || each.pixels <= std::get<3>(figures))
        continue;
      std::get<2>(figures) = static_cast<std::int32_t>(each.layer);
      std::get<3>(figures) = each.pixels;
    }
    return figures;
  }

  const std::vector<Mask>& layers_;
  std::size_t width_, height_;
  std::vector<int> labels_;
  int count_ = 1;
  std::vector<Sucking> sucking_;
};

}  // namespace

TEST_CASE("A cup with its floor at the plate sucks until the print ends") {
  const auto voids = voids_of({kFull, kRing, kRing});
  REQUIRE(voids.size() == 1);
  CHECK(figures_of(voids[0]) == VoidFigures{1, 2, 1, 1, 200, false, false});
  CHECK(voids[0].center.x == 2.5);
  CHECK(voids[0].center.y == 2.5);
}

TEST_CASE("A hollow sucks from where it is closed below, and up to its hole, its roof or the print's end") {
  struct Row {
    const char* what;
    std::vector<Rows> layers;
    std::optional<VoidFigures> figures;  // none if the hollow does not suck
  };
  for (const Row& row : {
           Row{"a cup with its mouth on the plate, which closes it",
               {kRing, kRing, kFull},
               VoidFigures{0, 1, 0, 1, 200, true, true}},
           Row{"a cup with its mouth above the plate", {kNothing, kRing, kRing, kFull}, {}},
           Row{"a tube on the plate", {kRing, kRing, kRing}, VoidFigures{0, 2, 0, 1, 300, true, false}},
           Row{"a closed hollow",
               {kFull, kRing, kRing, kFull, kFull},
               VoidFigures{1, 2, 1, 1, 200, false, true}},
           Row{"a hollow with a hole in its side, which is never closed",
               {kFull, kRing, kOpenRing, kRing, kRing, kFull},
               VoidFigures{1, 1, 1, 1, 100, false, false}},
           Row{"a hollow with a hole at its bottom", {kOpenRing, kRing, kRing, kFull}, {}},
       }) {
    CAPTURE(row.what);
    const auto voids = voids_of(row.layers);
    REQUIRE(voids.size() == (row.figures ? 1U : 0U));
    if (row.figures) CHECK(figures_of(voids[0]) == *row.figures);
  }
}

TEST_CASE("Two hollows that meet are one from there on, and a corner is no way out") {
  const Rows two = {".......", ".#####.", ".#.#.#.", ".#####.", "......."};
  const Rows one = {".......", ".#####.", ".#...#.", ".#####.", "......."};
  const Rows roof = {".......", ".#####.", ".#####.", ".#####.", "......."};
  const auto voids = voids_of({roof, two, one, roof});
  REQUIRE(voids.size() == 1);
  CHECK(figures_of(voids[0]) == VoidFigures{1, 2, 2, 3, 500, false, true});
  const Rows corner = {".......", "..####.", ".#...#.", ".#####.", "......."};
  CHECK(voids_of({roof, corner, roof}).size() == 1);
}

TEST_CASE("A hollow that branches opens as a whole when one of its arms does") {
  const Rows one = {".......", ".#####.", ".#...#.", ".#####.", "......."};
  const Rows arms = {".......", ".#####.", ".#.#.#.", ".#####.", "......."};
  const Rows open = {".......", ".#####.", ".#.#...", ".#####.", "......."};
  const Rows roof = {".......", ".#####.", ".#####.", ".#####.", "......."};
  const auto voids = voids_of({roof, one, arms, open, arms, roof});
  REQUIRE(voids.size() == 1);
  CHECK(figures_of(voids[0]) == VoidFigures{1, 2, 1, 3, 500, false, false});
}

TEST_CASE("A gap that touches the picture's edge is outside") {
  CHECK(voids_of({{"#####", "#####", "#####"}, {"##.##", "#...#", "#####"}}).empty());
  CHECK(voids_of({{"#####", "#####", "#####"}, {"#####", "#...#", "##.##"}}).empty());
  CHECK(voids_of({{"#####", "#####", "#####"}, {"#####", "...##", "#####"}}).empty());
  CHECK(voids_of({{"#####", "#####", "#####"}, {"#####", "##...", "#####"}}).empty());
  CHECK(voids_of({{"#####", "#####", "#####"}, {"#####", "##.##", "#####"}}).size() == 1);
}

TEST_CASE("The next print begins without the voids of the one before") {
  VoidFinder finder;
  const MaskRuns ring = testing::runs_of(kRing), full = testing::runs_of(kFull);
  for (int print = 0; print < 2; ++print) {
    CHECK(finder.add_layer(full, {0, kVoidLayer}).empty());
    CHECK(finder.add_layer(ring, {1, kVoidLayer}).empty());
    const auto voids = finder.end();
    REQUIRE(voids.size() == 1);
    CHECK(figures_of(voids[0]) == VoidFigures{1, 1, 1, 1, 100, false, false});
  }
}

TEST_CASE("The voids found are those of a flood fill of all voxels after every layer") {
  CHECK(rc::check([] {
    const Pixels width{static_cast<std::int32_t>(draw(1, 9))}, height{static_cast<std::int32_t>(draw(1, 7))};
    const std::int64_t solid_of_ten = draw(4, 9);
    std::vector<Mask> layers(static_cast<std::size_t>(draw(1, 7)), Mask(width, height));
    for (Mask& mask : layers) {
      for (std::int32_t y = 0; y < height.count(); ++y) {
        for (std::uint8_t& pixel : mask.row(y))
          pixel = draw(1, 10) <= solid_of_ten ? 255 : 0;
      }
    }
    std::vector<VoidFigures> found;
    for (const MaskVoid& each : voids_of(layers))
      found.push_back(figures_of(each));
    std::ranges::sort(found);
    RC_ASSERT(found == VoidFlood(layers).voids());
  }));
}
