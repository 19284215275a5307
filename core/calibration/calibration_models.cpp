#include "core/calibration/calibration_models.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/calibration/joined_blocks.hpp"
#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Millimetres of the bridge model.
constexpr float kSpan = 4, kPost = 2, kBridgeDepth = 3, kBridgeBase = 1;

float post_left(std::size_t post) {
  return static_cast<float>(post) * (kPost + kSpan);
}

// Adds dots, the first one and others to the right of it.
void add_dots(std::size_t count, Block dot, std::vector<Block>& blocks) {
  constexpr float kPitch = 1;
  for (std::size_t i = 0; i < count; ++i) {
    blocks.push_back(dot);
    dot.low.x += kPitch;
    dot.high.x += kPitch;
  }
}
constexpr float kDot = 0.6F;  // mm

// Blocks of a row of the ladder, by their ends in mm.
constexpr std::array<std::pair<float, float>, 4> kLadder{{{0, 3}, {8, 10}, {19, 21}, {29, 30}}};
constexpr float kLadderWidth = 5, kLadderBase = 1.5F, kLadderTop = 5, kLadderGap = 3;

constexpr std::array kFins{0.1F, 0.2F, 0.3F, 0.5F, 1.0F};  // widths of fins and slots in mm
constexpr float kFinGap = 1.2F, kFinDepth = 2, kRecess = kDot;

// Adds fins and then slots between teeth, up to a height. Returns the width of both.
float add_fins(float top, std::vector<Block>& blocks) {
  float left = kFinGap;
  const auto add = [&](float width) {
    blocks.push_back({{left, 0, 0}, {left + width, kFinDepth, top}});
    left += width;
  };
  for (const float width : kFins) {
    add(width);
    left += kFinGap;
  }
  for (const float width : kFins) {
    add(kFinGap);
    left += width;
  }
  add(kFinGap);
  return left;
}

}  // namespace

std::vector<Facet> bridge_model(Millimeters layer_height, Millimeters clearance) {
  const double layer = layer_height.count();
  expects(layer >= 0.001 && layer <= 1, "a layer has a height");
  expects(clearance.count() >= 1 && clearance.count() <= 1000, "bridges have a clearance");
  const int layers =
      static_cast<int>(std::ceil((double{kBridgeBase} + clearance.count()) / layer)) + kBridgeLayers.back();
  const auto height = [layer](int of) { return static_cast<float>(of * layer); };
  const float right = post_left(kBridgeLayers.size()) + kPost, top = height(layers);
  std::vector<Block> blocks{{{0, -3, 0}, {right, kBridgeDepth, kBridgeBase}}};
  for (std::size_t post = 0; post <= kBridgeLayers.size(); ++post)
    blocks.push_back({{post_left(post), 0, kBridgeBase}, {post_left(post) + kPost, kBridgeDepth, top}});
  for (std::size_t bridge = 0; bridge < kBridgeLayers.size(); ++bridge) {
    const float left = post_left(bridge) + kPost;
    blocks.push_back({{left, 0, height(layers - kBridgeLayers[bridge])}, {left + kSpan, kBridgeDepth, top}});
    add_dots(bridge + 1, {{left, -2, kBridgeBase}, {left + kDot, -2 + kDot, kBridgeBase + kDot}}, blocks);
  }
  return joined(blocks);
}

Point bridge_middle(std::size_t bridge) {
  return {static_cast<double>(post_left(bridge) + kPost + kSpan / 2), static_cast<double>(kBridgeDepth) / 2};
}

std::vector<Facet> ladder_model() {
  const float end = kLadder.back().second, back = kLadderWidth + kLadderGap;
  std::vector<Block> blocks{{{0, 0, 0}, {end, kLadderWidth, kLadderBase}},
                            {{0, back, 0}, {kLadderWidth, back + end, kLadderBase}}};
  for (const auto& [from, to] : kLadder) {
    blocks.push_back({{from, 0, kLadderBase}, {to, kLadderWidth, kLadderTop}});
    blocks.push_back({{0, back + from, kLadderBase}, {kLadderWidth, back + to, kLadderTop}});
  }
  return joined(blocks);
}

std::vector<LadderLength> ladder_lengths() {
  std::vector<LadderLength> lengths;
  const auto add = [&lengths](LengthKind kind, float from, float to) {
    lengths.push_back({kind, static_cast<double>(to - from), Millimeters{from}, Millimeters{to}});
  };
  for (std::size_t block = kLadder.size(); block-- > 1;)
    add(LengthKind::Outer, 0, kLadder[block].second);
  for (const auto& [from, to] : {kLadder[0], kLadder[1]})
    add(LengthKind::Outer, from, to);
  for (std::size_t gap = 1; gap < kLadder.size(); ++gap)
    add(LengthKind::Inner, kLadder[gap - 1].second, kLadder[gap].first);
  return lengths;
}

std::vector<Facet> tower_model(const ExposureTower& tower) {
  expects(tower.steps >= 1 && tower.steps <= kMostTowerSteps, "a tower has some steps");
  expects(tower.base.count() > 0 && tower.step.count() > 0, "a tower's steps have a height");
  const auto level = [&tower](double step) {
    return static_cast<float>(tower.base.count() + step * tower.step.count());
  };
  std::vector<Block> blocks;
  const float right = add_fins(level(tower.steps), blocks);
  constexpr float kBody = 3;
  const auto front = [&tower](int step) { return -kBody - kRecess * static_cast<float>(tower.steps - step); };
  blocks.push_back({{0, front(-2), 0}, {right + kFinGap, kFinDepth + 1, level(0)}});
  for (int step = 0; step < tower.steps; ++step) {
    blocks.push_back({{0, front(step), level(step)}, {right, 0, level(step + 1)}});
    add_dots(static_cast<std::size_t>(step) + 1,
             {{1, front(step - 1), level(step)}, {1 + kDot, front(step), level(step + 0.5)}}, blocks);
  }
  return joined(blocks);
}

}  // namespace contourd
