// An open graphics card that drives outputs (/dev/dri/cardN). Closing it gives up DRM master and removes its
// pictures from the outputs. Not thread-safe except where noted.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hw/drm/connector.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

class Card {
 public:
  // Throws HardwareError if the card cannot be opened or has no outputs (a render-only card).
  explicit Card(const std::filesystem::path& path);

  [[nodiscard]] int fd() const { return fd_.get(); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] const std::string& driver() const { return driver_; }
  [[nodiscard]] dev_t number() const;
  // "/dev/dri/card0 (vc4)"
  [[nodiscard]] std::string name() const { return path_.string() + " (" + driver_ + ")"; }

  // True if this process is DRM master and so may set outputs. One program at a time is master; the first to
  // open a card becomes master at once.
  [[nodiscard]] bool is_master() const noexcept;
  // Becomes DRM master if no other program is. True if this process is master now.
  [[nodiscard]] bool try_become_master() const noexcept;
  // Becomes DRM master. Throws HardwareError that names the master, as far as this process may know.
  void become_master() const;

  // connectors() and connector() read the displays' EDID, which takes some milliseconds per display, 300 or
  // more with some. A process that is not master gets the kernel's last state instead. May be called from any
  // thread; page flips continue meanwhile.
  [[nodiscard]] std::vector<Connector> connectors() const;
  // Returns a disconnected connector without a name and modes if there is none with this id any more.
  [[nodiscard]] Connector connector(std::uint32_t id) const;
  // Returns the CRTCs' ids in the order of the bits of Connector::possible_crtcs.
  [[nodiscard]] std::vector<std::uint32_t> crtcs() const;

  // True if vblank times are CLOCK_MONOTONIC times.
  [[nodiscard]] bool has_monotonic_timestamps() const noexcept;
  // True if the driver reports vblanks; otherwise a flip's time is when the driver had processed it.
  [[nodiscard]] bool has_vblank(std::uint32_t crtc_id) const noexcept;

 private:
  std::filesystem::path path_;
  FileDescriptor fd_;
  std::string driver_;
};

// Returns the master's name and process from the kernel's list of a card's clients
// (/sys/kernel/debug/dri/N/clients): "Xorg (process 612)". Returns nullopt if no client is master.
[[nodiscard]] std::optional<std::string> master_among(std::string_view clients);

// Returns a clause that names the program that is DRM master of a card, as far as this process may know, such
// as "Xorg (process 612) is its DRM master". The source is that list if it can be read (usually only by
// root), else the processes that have the card open; if none is visible the clause says how to find out.
[[nodiscard]] std::string describe_master_holder(const std::filesystem::path& card);

// Opens the cards that the config allows: the card with its path, the cards with its driver's name, or all
// cards with outputs. Throws HardwareError that lists the existing cards if none matches.
[[nodiscard]] std::vector<Card> open_cards(const DrmDisplayConfig& config);

struct FoundOutput {
  Card card;
  Connector connector;
};
struct OutputSearch {
  std::optional<FoundOutput> found;
  std::string why_not;  // a sentence if nothing was found: the display is not connected
};
// Finds the output that the config selects and opens its card. Throws HardwareError that lists the existing
// cards or connectors if the config selects one that does not exist.
[[nodiscard]] OutputSearch find_output(const DrmDisplayConfig& config);

}  // namespace contourd
