#include "core/cure/underside_light.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns the greatest dose that the underside ever has, if the first layer gets a share of its light.
double greatest_dose(std::span<const double> doses, double first_share, const PeelLoss& loss) {
  double dose = first_share * doses.front(), greatest = dose;
  for (const double of_layer : doses.subspan(1)) {
    dose = std::max(dose * loss.kept - loss.lost, 0.0) + of_layer;
    greatest = std::max(greatest, dose);
  }
  return greatest;
}

// Returns the share of its light that the first layer may give. Nothing is subtracted at a peel, so that the
// dose after each layer grows in proportion to that share.
double greatest_share(std::span<const double> doses, double kept) {
  double share = 1, dose = 0, of_first = doses.front();
  for (std::size_t layer = 0; layer < doses.size() && of_first > 0; ++layer) {
    if (layer > 0) dose = dose * kept + doses[layer];
    share = std::min(share, (1 - dose) / of_first);
    of_first *= kept;
  }
  return std::max(share, 0.0);
}

double searched_share(std::span<const double> doses, const PeelLoss& loss) {
  double share = 0, too_much = 1;
  constexpr int kHalvings = 12;  // finer than 255 grey values
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = (share + too_much) / 2;
    (greatest_dose(doses, middle, loss) > 1 ? too_much : share) = middle;
  }
  return share;
}

}  // namespace

UndersideLight underside_light(std::span<const double> doses, const PeelLoss& loss, std::size_t most_dimmed) {
  expects(most_dimmed < doses.size(), "a layer is left that gets all its light");
  std::size_t dark = 0;
  while (dark < most_dimmed && greatest_dose(doses.subspan(dark), 0, loss) > 1)
    ++dark;
  const std::span<const double> lit = doses.subspan(dark);
  if (dark == most_dimmed || greatest_dose(lit, 1, loss) <= 1) return {dark, 1};
  return {dark, loss.lost == 0 ? greatest_share(lit, loss.kept) : searched_share(lit, loss)};
}

}  // namespace contourd
