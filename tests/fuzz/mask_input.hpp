// The mask fuzzer's interpretation of its bytes: a display, settings, a height and any facets. Values;
// thread-safe.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "tests/models/models.hpp"

namespace contourd::fuzz {

// The first bytes of the input; the facets follow, 36 bytes each, in memory layout.
struct MaskSettings {
  std::uint16_t width, height;  // size of the display; see display_of()
  std::uint16_t flags;          // bits such as kFit; the upper 8 bits: growth, see compensation_of()
  std::uint16_t height_part;    // a height within the model, in 65536ths
  float pitch_um;
  float z;  // another height, in the model's coordinates
};
static_assert(sizeof(MaskSettings) == 16);

inline constexpr unsigned kGrey = 1, kMirrorX = 2, kMirrorY = 4, kFit = 8, kCopies = 16, kLongDisplay = 32;

struct MaskInput {
  MaskSettings settings;
  models::Facets facets;  // finite
};

inline std::vector<std::byte> to_bytes(const MaskInput& input) {
  std::vector<std::byte> bytes(sizeof(MaskSettings) + input.facets.size() * sizeof(Facet));
  std::memcpy(bytes.data(), &input.settings, sizeof(MaskSettings));
  if (!input.facets.empty()) {
    std::memcpy(bytes.data() + sizeof(MaskSettings), input.facets.data(),
                input.facets.size() * sizeof(Facet));
  }
  return bytes;
}

// Reads the settings and the finite facets. REQUIRES: at least as many bytes as the settings have.
inline MaskInput from_bytes(std::span<const std::byte> bytes) {
  MaskInput input{};
  std::memcpy(&input.settings, bytes.data(), sizeof(MaskSettings));
  for (bytes = bytes.subspan(sizeof(MaskSettings)); bytes.size() >= sizeof(Facet);
       bytes = bytes.subspan(sizeof(Facet))) {
    Facet facet;
    std::memcpy(&facet, bytes.data(), sizeof(Facet));
    bool finite = true;
    for (const Vertex& v : facet.vertices)
      finite = finite && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    // The model reader refuses facets that are not finite.
    if (finite) input.facets.push_back(facet);
  }
  return input;
}

// Returns a display of up to 100 pixels a side, or with one side of the maximum length.
inline DisplayGeometry display_of(const MaskSettings& settings) {
  const bool is_long = (settings.flags & kLongDisplay) != 0;
  const bool sane = settings.pitch_um >= 0.001F && settings.pitch_um <= 1e6F;
  return {Pixels{1 + settings.width % (is_long ? 16384 : 100)},
          Pixels{1 + settings.height % (is_long ? 4 : 100)},
          Micrometers{sane ? static_cast<double>(settings.pitch_um) : 50.0}, (settings.flags & kMirrorX) != 0,
          (settings.flags & kMirrorY) != 0};
}

// Returns the growth in the upper byte of the flags, a signed number of 10 um.
inline Compensation compensation_of(const MaskSettings& settings) {
  return {.growth = Micrometers{static_cast<std::int8_t>(settings.flags >> 8) * 10.0}};
}

}  // namespace contourd::fuzz
