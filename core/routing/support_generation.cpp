#include "core/routing/support_generation.hpp"

#include <utility>

#include "core/clearance/lit_layers.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/routing/support_layout.hpp"

namespace contourd {

std::optional<Supports> make_supports(const SupportRequest& request, const std::stop_token& stop) {
  LitLayers layers;
  std::optional<HeldPlaces> places = find_overhangs(request, layers, stop);
  if (!places) return std::nullopt;
  return lay_out_supports(std::move(places->contacts), layers, request.display, request.settings, stop);
}

}  // namespace contourd
