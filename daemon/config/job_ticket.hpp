// How a job is to be printed, as its owner says: the file beside a model, or a plate's. Value types;
// thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "daemon/config/orientation_ticket.hpp"
#include "daemon/config/support_figures.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

// About the x axis first, then y, then z; right-handed.
struct RotationDegrees {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  bool operator==(const RotationDegrees&) const = default;
};

// Of the model's centre from the plate's centre.
struct PlateOffset {
  Millimeters x;
  Millimeters y;
  bool operator==(const PlateOffset&) const = default;
};

// A hole that is taken out of a model: a cylinder in its own millimetres, before it is turned and scaled.
struct DrainHole {
  double x_mm = 0, y_mm = 0, z_mm = 0;  // on the model's surface
  Direction inwards{};
  double diameter_mm = 0;
  double depth_mm = 0;  // from there
  bool operator==(const DrainHole&) const = default;
};

// What is to become of a model whose contours cannot be closed without a guess.
enum class CrackPolicy {
  Repair,  // close them all the same, and warn
  Refuse,  // print nothing
};

// Whether what hangs in the air is held by supports.
enum class SupportPolicy { Off, Auto };

// What a ticket says of them.
struct SupportTicket {
  SupportPolicy policy = SupportPolicy::Auto;
  std::vector<AskedSupportFigure> figures{};  // in the place of the resin's; with Auto
  bool operator==(const SupportTicket&) const = default;
};

// One model: how it is turned, how large it is and where it lies.
struct ModelTicket {
  std::string file;  // in the plate's folder; empty: the model that the ticket lies beside
  RotationDegrees rotation;
  std::optional<Direction> up;                     // never together with a rotation
  std::optional<OrientationTicket> orientation{};  // contourd finds it; never together with up or a rotation
  std::optional<Scale> scale;                      // never together with fit
  bool fit = false;                                // fill the display
  std::optional<PlateOffset> position;
  int copies = 1;
  std::vector<DrainHole> drain{};
  bool operator==(const ModelTicket&) const = default;
};

// Layers as thick as the slopes allow; what is not given is the resin's.
struct AdaptiveTicket {
  Nanometers cusp;
  std::optional<Nanometers> thinnest, thickest;
  bool operator==(const AdaptiveTicket&) const = default;
};

// A default-made ticket is what a model without a file gets.
struct JobTicket {
  std::optional<std::string> resin;        // profile name; not yet known to exist
  std::optional<Nanometers> layer_height;  // not yet checked against the resin
  std::optional<AdaptiveTicket> adaptive;  // never together with layer_height, or an exposure
  TicketOverrides overrides{};             // not yet checked against the resin's limits
  CrackPolicy cracks = CrackPolicy::Repair;
  std::optional<SupportTicket> supports{};         // the printer's own without it
  std::vector<ModelTicket> models{ModelTicket{}};  // exactly one in a model's own ticket
  bool operator==(const JobTicket&) const = default;
};

// The name of a plate's ticket in its folder.
inline constexpr const char* kPlateTicket = "plate.json";

// Reads NAME.json from beside NAME.stl. Throws ConfigError with everything that is wrong with it.
[[nodiscard]] JobTicket load_job_ticket(const std::filesystem::path& path, Links links = Links::Follow);
// The same for text at hand; `file` is its name in messages.
[[nodiscard]] JobTicket parse_job_ticket(std::string_view text, std::string file);

// Reads a plate's plate.json. The files that it names need not be there. Throws ConfigError with everything
// that is wrong with it.
[[nodiscard]] JobTicket load_plate_ticket(const std::filesystem::path& path, Links links = Links::Follow);

}  // namespace contourd
