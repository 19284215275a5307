// contourctl: inspects and slices models with the contour core, and talks to a running contourd.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <optional>
#include <system_error>

#include "core/stl_reader.hpp"
#include "daemon/control_defaults.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "daemon/readable.hpp"

namespace contourd::ctl {
namespace {

// What the user typed, before it has a unit.
struct SliceWords {
  double z_mm = 0;
  double layer_height_um = 0;
  double pixel_pitch_um = 50;
  std::string display = "1920x1080";
  std::string anti_aliasing = "on";
  std::string mask, masks, csv, contours;
};

DisplayGeometry parse_display(const SliceWords& words) {
  DisplayGeometry display;
  int width = 0, height = 0, used = 0;
  const int parts = std::sscanf(words.display.c_str(), "%dx%d%n", &width, &height, &used);
  constexpr int kLargest = 16384;
  if (parts != 2 || static_cast<std::size_t>(used) != words.display.size() || width < 1 || height < 1 ||
      width > kLargest || height > kLargest) {
    throw UsageError(
        fmt::format("--display {}: expected WIDTHxHEIGHT, each 1 to {} pixels", words.display, kLargest));
  }
  if (!(words.pixel_pitch_um >= 0.1 && words.pixel_pitch_um <= 10000)) {
    throw UsageError(fmt::format("--pixel-pitch-um {}: expected 0.1 to 10000", words.pixel_pitch_um));
  }
  display.width = Pixels{width};
  display.height = Pixels{height};
  display.pixel_pitch = Micrometers{words.pixel_pitch_um};
  return display;
}

void set_if_given(std::optional<std::filesystem::path>& path, const std::string& word) {
  if (!word.empty()) path = word;
}

SliceOptions parse_slice(SliceOptions options, const SliceWords& words, bool has_z, bool has_layer_height) {
  options.display = parse_display(words);
  options.anti_aliasing = words.anti_aliasing == "on" ? AntiAliasing::On : AntiAliasing::Off;
  set_if_given(options.mask, words.mask);
  set_if_given(options.masks, words.masks);
  set_if_given(options.csv, words.csv);
  set_if_given(options.contours, words.contours);
  if (has_z == has_layer_height) throw UsageError("slice needs either --z or --layer-height-um");
  if (has_z) {
    if (!std::isfinite(words.z_mm))
      throw UsageError(fmt::format("--z {}: expected a finite number", words.z_mm));
    options.z = Millimeters{words.z_mm};
    if (options.masks || options.csv || options.contours) {
      throw UsageError("--masks, --csv and --contours go with --layer-height-um");
    }
  } else {
    const auto height = to_nanometers(to_millimeters(Micrometers{words.layer_height_um}));
    if (!height || *height < Nanometers{1000}) {
      throw UsageError(fmt::format("--layer-height-um {}: expected 1 or more", words.layer_height_um));
    }
    options.layer_height = height;
    if (options.mask) throw UsageError("--mask goes with --z");
  }
  return options;
}

// An unset shell variable must not become 0 or "no output".
const CLI::Validator kNotEmpty([](const std::string& word) { return word.empty() ? "it is empty" : ""; }, "");

int run(int argc, char** argv) {
  CLI::App app{"Inspects and slices STL models, and talks to contourd."};
  app.require_subcommand(1);
  app.set_version_flag("--version", CONTOURD_VERSION);
  std::function<int()> chosen;

  InspectOptions inspect_options;
  CLI::App* inspect_app =
      app.add_subcommand("inspect", "Say what a model's file holds and what is wrong with it");
  inspect_app->add_option("MODEL", inspect_options.model, "STL file")->required();
  inspect_app->add_flag("--json", inspect_options.json, "Print JSON");
  inspect_app->callback([&] { chosen = [&] { return inspect(inspect_options); }; });

  SliceOptions slice_options;
  SliceWords words;
  CLI::App* slice_app = app.add_subcommand("slice", "Cut a model at one height, or into layers");
  slice_app->add_option("MODEL", slice_options.model, "STL file")->required();
  CLI::Option* z =
      slice_app->add_option("--z", words.z_mm, "Height of the cut, mm, in the file's coordinates")
          ->check(kNotEmpty);
  CLI::Option* layer_height =
      slice_app->add_option("--layer-height-um", words.layer_height_um, "Layer height, um")->check(kNotEmpty);
  slice_app->add_option("--mask", words.mask, "Write the mask at --z to this PNG file")->check(kNotEmpty);
  slice_app->add_option("--masks", words.masks, "Write one PNG file a layer to this folder: 0001.png ...")
      ->check(kNotEmpty);
  slice_app
      ->add_option("--csv", words.csv, "Write each layer's measurements to this file, and FILE-summary.csv")
      ->check(kNotEmpty);
  slice_app
      ->add_option("--contours", words.contours,
                   "Write one CSV file of contour points a layer to this folder")
      ->check(kNotEmpty);
  slice_app->add_option("--display", words.display, "Pixels, WIDTHxHEIGHT")
      ->capture_default_str()
      ->check(kNotEmpty);
  slice_app->add_option("--pixel-pitch-um", words.pixel_pitch_um, "Side of a pixel on the plate, um")
      ->capture_default_str()
      ->check(kNotEmpty);
  slice_app->add_flag("--fit", slice_options.fit, "Fit the model to the display instead of true scale");
  slice_app->add_option("--aa", words.anti_aliasing, "Anti-aliasing: grey masks by area coverage, or 1-bit")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str()
      ->check(kNotEmpty);
  slice_app->add_flag("--json", slice_options.json, "Print JSON");
  slice_app->callback([&] {
    chosen = [&] {
      return slice(parse_slice(slice_options, words, z->count() > 0, layer_height->count() > 0));
    };
  });

  ClientOptions client;
  const char* from_environment = std::getenv("CONTOURD_SOCKET");
  client.socket = from_environment != nullptr ? from_environment : kDefaultSocket;
  const auto add_client = [&](const char* name, const char* help, std::function<int()> call) -> CLI::App* {
    CLI::App* command = app.add_subcommand(name, help);
    command->add_option("--socket", client.socket, "contourd's control socket (or CONTOURD_SOCKET)")
        ->capture_default_str()
        ->check(kNotEmpty);
    command->add_flag("--json", client.json, "Print JSON, one message a line");
    command->callback([&chosen, call = std::move(call)] { chosen = call; });
    return command;
  };
  add_client("status", "What the printer is doing", [&] { return request(client, "status"); });
  std::optional<std::string> job;
  add_client("watch", "Follow the print with a progress bar until it ends",
             [&] { return watch(client, job); })
      ->add_option("--job", job, "Until the job of this name has ended")
      ->check(kNotEmpty);
  add_client("queue", "The jobs that wait", [&] { return request(client, "queue"); });
  add_client("pause", "Pause after the layer under way", [&] { return request(client, "pause"); });
  add_client("resume", "Go on after a pause", [&] { return request(client, "resume"); });
  add_client("cancel", "End the print under way: light off, plate up",
             [&] { return request(client, "cancel"); });
  add_client("plate-cleared", "Tell contourd that the plate is free for the next job",
             [&] { return request(client, "plate_cleared"); });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kOk : kBadUsage;
  }
  const int code = chosen();
  if (std::fflush(stdout) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot write the result");
  return code;
}

// One line, whatever a file is called.
int complain(int code, const char* why) {
  fmt::print(stderr, "contourctl: {}\n", printable(why));
  return code;
}

}  // namespace
}  // namespace contourd::ctl

int main(int argc, char** argv) {
  using namespace contourd::ctl;
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    return complain(kBadUsage, error.what());
  } catch (const contourd::StlError& error) {
    return complain(kBadData, error.what());
  } catch (const OutputError& error) {
    return complain(kCannotCreate, error.what());
  } catch (const DaemonError& error) {
    return complain(kUnavailable, error.what());
  } catch (const std::system_error& error) {
    return complain(std::ferror(stdout) != 0 ? kCannotCreate : kNoInput, error.what());
  } catch (const std::bad_alloc&) {
    return complain(kBadData, "the model does not fit into this machine's memory");
  } catch (const std::exception& error) {
    return complain(kFailed, error.what());
  }
}
