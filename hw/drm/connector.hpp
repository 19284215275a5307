// A snapshot of the kernel's description of a connector. Value type and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hw/drm/mode.hpp"
#include "hw/enum_names.hpp"

namespace contourd {

struct Connector {
  enum class Status { Connected, Disconnected, Unknown };

  std::uint32_t id = 0;
  std::string name;  // "HDMI-A-1"
  Status status = Status::Unknown;
  PictureSize size;
  std::vector<Mode> modes;
  std::uint32_t possible_crtcs = 0;  // bit n: the card's n-th CRTC can feed it
  std::uint32_t crtc_id = 0;         // the CRTC that feeds it now, or 0
};

template <>
inline constexpr auto kNames<Connector::Status> =
    names_to<Connector::Status::Unknown>("connected, disconnected, connection unknown");

// "HDMI-A-1 (connected)"
[[nodiscard]] std::string describe(const Connector& connector);

// A card's outputs, as choose_output() takes them.
struct CardOutputs {
  std::string card;  // "/dev/dri/card0 (vc4)"
  std::vector<Connector> connectors;
};

struct OutputIndex {
  std::size_t card = 0, connector = 0;
};

// Finds the output that the config selects among these cards. Without a connector's name in the config this
// is the first connected output, or nullopt if none is connected. With a name it is the first connected
// output of that name, else the first of that name. Throws HardwareError that lists the connectors if none
// has the name.
[[nodiscard]] std::optional<OutputIndex> choose_output(std::span<const CardOutputs> cards,
                                                       const DrmDisplayConfig& config);

// "/dev/dri/card0 (vc4): HDMI-A-1 (connected), HDMI-A-2 (disconnected)"
[[nodiscard]] std::string describe(std::span<const CardOutputs> cards);

}  // namespace contourd
