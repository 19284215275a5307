// Hollows that the models close on all sides: a support in one cannot be taken out. A hollow that only the
// plate closes is open once the part is taken off. Immutable; thread-safe. Memory: 4 bytes per run of the
// layers.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

class SealedHollows {
 public:
  // `layers` must outlive the object. Blocks for one pass over all runs.
  explicit SealedHollows(const LitLayers& layers);

  // True if a contact at that place, on an underside, lies in a sealed hollow.
  [[nodiscard]] bool holds(const PlatePoint& contact) const;
  // True if an overhang in a sealed hollow prints without the contact: material in the layer beneath is no
  // farther than resin bridges, as around the top of a dome.
  [[nodiscard]] bool is_bridged(const SupportContact& contact, Millimeters bridge) const;

 private:
  [[nodiscard]] std::optional<PlatePoint> dark_beneath(const PlatePoint& contact) const;

  // The dark pixels between two runs of a row have the left run's number.
  using Gap = std::uint32_t;

  [[nodiscard]] Gap root_of(Gap gap);
  void join(Gap a, Gap b);
  void join_with(std::int32_t layer, std::int32_t row, std::span<const LitLayers::Run> neighbours);
  [[nodiscard]] Gap outside() const { return static_cast<Gap>(parents_.size() - 1); }

  const LitLayers& layers_;
  std::vector<Gap> parents_;  // by gap, then the outside; after construction each gap's root
};

}  // namespace contourd
