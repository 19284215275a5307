#include "hw/drm/connector.hpp"

#include "hw/hardware_error.hpp"

namespace contourd {

std::string describe(const Connector& connector) {
  return connector.name + " (" + std::string(name_of(connector.status)) + ")";
}

std::string describe(std::span<const CardOutputs> cards) {
  std::string text;
  for (const CardOutputs& card : cards) {
    text += (text.empty() ? "" : "; ") + card.card + ": ";
    for (std::size_t i = 0; i < card.connectors.size(); ++i)
      text += (i == 0 ? "" : ", ") + describe(card.connectors[i]);
    if (card.connectors.empty()) text += "no connector";
  }
  return text.empty() ? "no card with connectors" : text;
}

std::optional<OutputIndex> choose_output(std::span<const CardOutputs> cards, const DrmDisplayConfig& config) {
  std::optional<OutputIndex> named;
  for (std::size_t card = 0; card < cards.size(); ++card) {
    for (std::size_t i = 0; i < cards[card].connectors.size(); ++i) {
      const Connector& connector = cards[card].connectors[i];
      if (config.connector && connector.name != *config.connector) continue;
      if (connector.status == Connector::Status::Connected) return OutputIndex{card, i};
      if (config.connector && !named) named = OutputIndex{card, i};
    }
  }
  if (config.connector && !named)
    throw HardwareError("there is no connector " + *config.connector + "; connectors: " + describe(cards));
  return named;
}

}  // namespace contourd
