#include "core/support/supports_of_copies.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

namespace contourd {
namespace {

// The trees of a structure: primitives that share an end belong to one tree.
class Trees {
 public:
  explicit Trees(std::span<const SupportPrimitive> primitives) : parent_(primitives.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    std::map<std::tuple<double, double, double>, std::size_t> at;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      for (const PlatePoint& end : ends_of(primitives[i])) {
        const auto [known, is_new] = at.try_emplace({end.x, end.y, end.z}, i);
        if (!is_new) parent_[root(i)] = root(known->second);
      }
    }
  }

  // Returns the number of the tree to which a primitive belongs.
  [[nodiscard]] std::size_t root(std::size_t primitive) {
    while (parent_[primitive] != primitive)
      primitive = parent_[primitive] = parent_[parent_[primitive]];
    return primitive;
  }

 private:
  static std::array<PlatePoint, 2> ends_of(const SupportPrimitive& primitive) {
    if (const auto* const ball = std::get_if<Ball>(&primitive)) return {ball->center, ball->center};
    const auto& frustum = std::get<Frustum>(primitive);
    return {frustum.lower, frustum.upper};
  }

  std::vector<std::size_t> parent_;
};

const PlatePoint& upper_end(const SupportPrimitive& primitive) {
  if (const auto* const ball = std::get_if<Ball>(&primitive)) return ball->center;
  return std::get<Frustum>(primitive).upper;
}

bool leads_to(const PlatePoint& end, const CopyOutline& copy) {
  constexpr double kBeside = 0.1;  // mm between a model's wall and the tip of its support
  return end.x >= copy.least.x - kBeside && end.x <= copy.most.x + kBeside &&
         end.y >= copy.least.y - kBeside && end.y <= copy.most.y + kBeside;
}

}  // namespace

std::shared_ptr<const SupportStructure> supports_of_printed(const SupportStructure& supports,
                                                            std::span<const CopyOutline> copies) {
  const std::span<const SupportPrimitive> primitives = supports.primitives();
  Trees trees(primitives);
  // By root: the tree leads to a copy that is no longer printed, or to one that is.
  std::vector<std::uint8_t> to_dark(primitives.size()), to_printed(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i)
    for (const CopyOutline& copy : copies)
      if (leads_to(upper_end(primitives[i]), copy))
        (copy.is_printed ? to_printed : to_dark)[trees.root(i)] = 1;
  std::vector<SupportPrimitive> left;
  for (std::size_t i = 0; i < primitives.size(); ++i)
    if (to_dark[trees.root(i)] == 0 || to_printed[trees.root(i)] != 0) left.push_back(primitives[i]);
  return std::make_shared<const SupportStructure>(std::move(left));
}

}  // namespace contourd
