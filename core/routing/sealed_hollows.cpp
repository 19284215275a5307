#include "core/routing/sealed_hollows.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

SealedHollows::SealedHollows(const LitLayers& layers) : layers_(layers) {
  for (Gap gap = 0; gap <= layers.runs(); ++gap)
    parents_.push_back(gap);
  for (std::int32_t layer = 0; layer < layers.layers(); ++layer) {
    for (std::int32_t row = 0; row < layers.rows(); ++row) {
      if (layers.runs_in(layer, row).size() < 2) continue;
      for (const auto& [up, aside] : {std::pair{0, -1}, {0, 1}, {-1, 0}, {1, 0}})
        join_with(layer, row, layers.runs_in(layer + up, row + aside));
    }
  }
  for (Gap gap = 0; gap < outside(); ++gap)
    parents_[gap] = root_of(gap);
}

// Joins the gaps of a row with those that they touch in a neighbouring row, of the same layer or of the next.
void SealedHollows::join_with(std::int32_t layer, std::int32_t row,
                              std::span<const LitLayers::Run> neighbours) {
  const std::span<const LitLayers::Run> runs = layers_.runs_in(layer, row);
  const Gap first = layers_.number_of(runs.front());
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    const std::int32_t left = runs[i].end, right = runs[i + 1].first;
    const Gap gap = first + static_cast<Gap>(i);
    if (neighbours.empty() || left < neighbours.front().first || right > neighbours.back().end) {
      join(gap, outside());
      continue;
    }
    while (next + 1 < neighbours.size() && neighbours[next + 1].first <= left)
      ++next;
    for (std::size_t k = next; k + 1 < neighbours.size() && neighbours[k].end < right; ++k)
      if (neighbours[k + 1].first > left) join(gap, layers_.number_of(neighbours[k]));
  }
}

SealedHollows::Gap SealedHollows::root_of(Gap gap) {
  while (parents_[gap] != gap) {
    parents_[gap] = parents_[parents_[gap]];
    gap = parents_[gap];
  }
  return gap;
}

void SealedHollows::join(Gap a, Gap b) {
  a = root_of(a);
  b = root_of(b);
  parents_[std::min(a, b)] = std::max(a, b);
}

// Returns the first place straight below the contact that lies in a gap: the contact's own layer may be lit.
std::optional<PlatePoint> SealedHollows::dark_beneath(const PlatePoint& contact) const {
  for (const int down : {0, 1, 2}) {
    const PlatePoint below{contact.x, contact.y, contact.z - down * layers_.step_mm()};
    if (layers_.gap_at(below)) return below;
  }
  return std::nullopt;
}

bool SealedHollows::holds(const PlatePoint& contact) const {
  const std::optional<PlatePoint> beneath = dark_beneath(contact);
  return beneath && parents_[*layers_.gap_at(*beneath)] != outside();
}

bool SealedHollows::is_bridged(const SupportContact& contact, Millimeters bridge) const {
  if (contact.cause != ContactCause::Overhang || !holds(contact.place)) return false;
  return layers_.lit_around(*dark_beneath(contact.place), bridge.count(), 1) > 0;
}

}  // namespace contourd
