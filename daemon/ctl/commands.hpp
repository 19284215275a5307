// contourctl's commands. Each takes its options as a value, prints its result, and returns the exit code;
// what is wrong with the data or the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/engine/contour_engine.hpp"
#include "core/formats/model_reader.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

// read_model_file(), with the file's name in front of what is wrong with it; what needs more memory than
// there is is not read. Throws as that does.
[[nodiscard]] Model read_model(const std::filesystem::path& path);

struct InspectOptions {
  std::filesystem::path model;
  bool json = false;
};
int inspect(const InspectOptions& options);

struct SliceOptions {
  std::filesystem::path model;
  bool json = false;
  // Exactly one of the three is given: one height (the file's coordinates), layers of one height, or adaptive
  // ones.
  std::optional<Millimeters> z;
  std::optional<Nanometers> layer_height;
  std::optional<AdaptiveLayers> adaptive;

  EngineSettings engine;
  bool fit = false;
  std::optional<std::filesystem::path> lamp;  // to be read into engine.lamp

  std::optional<std::filesystem::path> mask;      // one PNG, with z
  std::optional<std::filesystem::path> masks;     // a folder of PNGs, with layers
  std::optional<std::filesystem::path> csv;       // with layers
  std::optional<std::filesystem::path> contours;  // a folder of CSVs, with layers
  bool force = false;                             // replaces what an earlier slice left in these folders
};
int slice(SliceOptions options);

struct AnalyzeOptions {
  std::filesystem::path model;
  bool json = false;
  std::optional<std::filesystem::path> html;  // one self-contained page

  // As contourd would print it: with this configuration, and a job's ticket.
  std::optional<std::filesystem::path> printer, ticket;
  // Without a printer: in the middle of this display, and so much time for every layer.
  DisplayGeometry display;
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Nanometers layer_height{50'000};
  Duration layer_time{};
};
int analyze(const AnalyzeOptions& options);

struct ClientOptions {
  std::filesystem::path socket;
  bool json = false;
};
// Sends one request (`method` as on the socket) and prints its answer for a person, or as it came.
int request(const ClientOptions& options, const std::string& method);
// Shows the print under way until it ends, or until the job of that name has ended (which may be before the
// call); one that is nowhere for some seconds is told.
int watch(const ClientOptions& options, const std::optional<std::string>& job);

}  // namespace contourd::ctl
