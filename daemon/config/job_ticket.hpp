// The user's settings for a job: a ticket, the JSON file beside a model or in a plate's folder. Value types;
// thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/hollow/hollow_settings.hpp"
#include "core/model/length_unit.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"
#include "daemon/config/support_figures.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd {

// The goals by which contourd chooses the orientation.
struct OrientationTicket {
  OrientationPreset preset = OrientationPreset::Auto;
  std::vector<KeepClean> keep_clean{};
  bool operator==(const OrientationTicket&) const = default;
};

// Right-handed rotations about the x axis first, then y, then z.
struct RotationDegrees {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  bool operator==(const RotationDegrees&) const = default;
};

// The offset of the model's centre from the plate's centre.
struct PlateOffset {
  Millimeters x;
  Millimeters y;
  bool operator==(const PlateOffset&) const = default;
};

// A hole to cut into a model: a cylinder in the model's own millimetres, before rotation and scaling.
struct DrainHole {
  double x_mm = 0, y_mm = 0, z_mm = 0;  // on the model's surface
  Direction inwards{};
  double diameter_mm = 0;
  double depth_mm = 0;  // from that point inwards
  bool operator==(const DrainHole&) const = default;
};

// The treatment of a model whose contours can only be closed by a guess.
enum class CrackPolicy {
  Repair,  // close them anyway and warn
  Refuse,  // print nothing
};

// The choice between printing overhangs as they are and generating supports for them. A model that contourd
// recognises as carrying supports in its file keeps to them with Auto, and gets others with On. With InFile,
// every model is one that carries them.
enum class SupportPolicy { Off, Auto, On, InFile };
// Returns the policy with the name "auto", "on" or "in the file"; Off for any other name.
[[nodiscard]] SupportPolicy support_policy(std::string_view name);
// True if models may be lifted and get supports.
[[nodiscard]] constexpr bool adds_supports(SupportPolicy policy) {
  return policy == SupportPolicy::Auto || policy == SupportPolicy::On;
}

// The supports that a ticket asks for.
struct SupportTicket {
  SupportPolicy policy = SupportPolicy::Auto;
  std::vector<AskedSupportFigure> figures{};  // replace the resin's; only with On
  bool operator==(const SupportTicket&) const = default;
};

// One model's orientation, size and position.
struct ModelTicket {
  std::string file;                    // in the plate's folder; empty: the model beside the ticket
  std::vector<std::string> entries{};  // models and folders of a ZIP archive; empty: all of it
  std::optional<LengthUnit> unit{};    // of the file's coordinates; without it, mm
  RotationDegrees rotation;
  std::optional<Direction> up;                     // never together with a rotation
  std::optional<OrientationTicket> orientation{};  // contourd's choice; never together with up or a rotation
  std::optional<Scale> scale;                      // never together with fit
  bool fit = false;                                // fill the display
  std::optional<PlateOffset> position;
  int copies = 1;
  std::vector<DrainHole> drain{};
  std::optional<HollowSettings> hollow{};  // lengths in the print; without it, the model stays as it is
  bool operator==(const ModelTicket&) const = default;
};

// Layers as thick as the slopes allow; omitted values are the resin's.
struct AdaptiveTicket {
  Nanometers cusp;
  std::optional<Nanometers> thinnest, thickest;
  bool operator==(const AdaptiveTicket&) const = default;
};

// A job's settings. A default-constructed ticket is used for a model without a ticket file.
struct JobTicket {
  std::optional<std::string> resin;                // profile name; not yet known to exist
  std::optional<Nanometers> layer_height;          // not yet checked against the resin
  std::optional<AdaptiveTicket> adaptive;          // never together with layer_height, or an exposure
  TicketOverrides overrides{};                     // not yet checked against the resin's limits
  bool exposures_of_file = false;                  // never together with an exposure
  std::optional<Undersides> undersides{};          // without it, the resin's setting
  std::optional<PrintWay> mode{};                  // without it, the resin's setting
  std::optional<CrackPolicy> cracks{};             // without it, repair, but wide gaps need confirmation
  bool dry = false;                                // all moves and masks, but no light
  bool confirm = false;                            // wait until a user accepts the job
  std::optional<SupportTicket> supports{};         // without it, the printer's setting
  std::vector<ModelTicket> models{ModelTicket{}};  // exactly one in a model's own ticket
  bool operator==(const JobTicket&) const = default;
};

// The name of a plate's ticket in its folder.
inline constexpr const char* kPlateTicket = "plate.json";

// Reads NAME.json, the ticket of NAME.stl. Throws ConfigError with all violations.
[[nodiscard]] JobTicket load_job_ticket(const std::filesystem::path& path, Links links = Links::Follow);
// Reads a model's ticket from `text`; `file` is its name in messages. Throws ConfigError with all violations.
[[nodiscard]] JobTicket parse_job_ticket(std::string_view text, std::string file);

// Reads a plate's plate.json. The model files that it names need not exist. Throws ConfigError with all
// violations.
[[nodiscard]] JobTicket load_plate_ticket(const std::filesystem::path& path, Links links = Links::Follow);

}  // namespace contourd
