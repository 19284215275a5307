// A graphics card that drives outputs (/dev/dri/cardN), open. Closing it gives up DRM master and whatever it
// showed. Not thread-safe.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hw/drm/connector.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

class Card {
 public:
  // Throws HardwareError when it cannot be opened or has no outputs to set (a card that only computes).
  explicit Card(const std::filesystem::path& path);

  [[nodiscard]] int fd() const { return fd_.get(); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const std::string& driver() const { return driver_; }
  [[nodiscard]] dev_t number() const;
  // "/dev/dri/card0 (vc4)"
  [[nodiscard]] std::string name() const { return path_.string() + " (" + driver_ + ")"; }

  // DRM master is who may set outputs: one program at a time. The first to open a card is it at once.
  [[nodiscard]] bool is_master() const noexcept;
  // Whether this process has it now.
  [[nodiscard]] bool try_become_master() const noexcept;
  // Throws HardwareError that says who has it, as far as this process may know.
  void become_master() const;

  // Both ask the displays (EDID), which takes some milliseconds each, 300 and more with some; whoever is not
  // master gets what the kernel last heard. From any thread; flips go on meanwhile.
  [[nodiscard]] std::vector<Connector> connectors() const;
  // Disconnected, and without modes, when it is no longer there.
  [[nodiscard]] Connector connector(std::uint32_t id) const;
  // In the order of Connector::possible_crtcs.
  [[nodiscard]] std::vector<std::uint32_t> crtcs() const;

  // Vblank times are of CLOCK_MONOTONIC.
  [[nodiscard]] bool has_monotonic_timestamps() const noexcept;
  // The driver tells vblanks; else a flip's time is when the driver was done with it.
  [[nodiscard]] bool has_vblank(std::uint32_t crtc_id) const noexcept;

 private:
  std::filesystem::path path_;
  FileDescriptor fd_;
  std::string driver_;
};

// The cards that the config allows, opened: that of its path, those of its driver's name, or all that have
// outputs. Throws HardwareError with what there is when there is none.
[[nodiscard]] std::vector<Card> open_cards(const DrmDisplayConfig& config);

struct FoundOutput {
  Card card;
  Connector connector;
};
struct OutputSearch {
  std::optional<FoundOutput> found;
  std::string why_not;  // a sentence: the display is not connected
};
// The output that the config means, on its card, opened. Throws HardwareError with what there is instead.
[[nodiscard]] OutputSearch find_output(const DrmDisplayConfig& config);

}  // namespace contourd
