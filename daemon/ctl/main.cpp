// contourctl: inspects and slices models with the contour core, and talks to a running contourd.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "core/formats/model_reader.hpp"
#include "core/layers/layers.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/commands/config_command.hpp"
#include "daemon/ctl/commands/diagnose_command.hpp"
#include "daemon/ctl/commands/help_command.hpp"
#include "daemon/ctl/commands/history_command.hpp"
#include "daemon/ctl/commands/jog_command.hpp"
#include "daemon/ctl/commands/level_command.hpp"
#include "daemon/ctl/commands/logs_command.hpp"
#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/commands/mask_command.hpp"
#include "daemon/ctl/commands/queue_command.hpp"
#include "daemon/ctl/commands/switches_command.hpp"
#include "daemon/ctl/models/analyze_command.hpp"
#include "daemon/ctl/models/inspect_command.hpp"
#include "daemon/ctl/models/orient_command.hpp"
#include "daemon/ctl/models/preview_command.hpp"
#include "daemon/ctl/models/slice_command.hpp"
#include "daemon/ctl/models/support_command.hpp"
#include "daemon/ctl/setup/setup_command.hpp"
#include "daemon/ctl/submit/offer_command.hpp"
#include "daemon/ctl/submit/submit_command.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/watch/watch_command.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/prepare/job_settings.hpp"
#include "daemon/system/command_line.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

// Arguments as the user typed them, before they have units.
struct DisplayArgs {
  double pixel_pitch_um = 50;
  std::string display = "1920x1080";
};

struct SliceArgs {
  std::optional<double> z_mm, layer_height_um, cusp_um;
  double min_layer_um = 25, max_layer_um = 100;
  DisplayArgs display;
  std::string anti_aliasing = "on";
  std::string mask, masks, csv, contours;
  double grow_um = 0, elephant_foot_um = 0, elephant_foot_height_um = 0, gamma = 1;
  int threshold = 0;
  std::string uniformity_mask;
  std::string supports = "off";
  std::optional<double> scale;
  std::optional<std::string> up;
};

struct AnalyzeArgs {
  double layer_height_um = 50;
  double layer_time_s = 10;
  DisplayArgs display;
  std::string anti_aliasing = "on";
  std::string html, printer, ticket;
  std::optional<std::string> supports;
  std::optional<double> scale;
  std::optional<std::string> up;
};

struct SupportArgs {
  DisplayArgs display;
  double layer_height_um = 50;
  std::optional<double> scale;
  std::optional<std::string> up;
  std::string stl;
};

DisplayGeometry parse_display(const DisplayArgs& words) {
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

// Parses the corrections of masks that a resin's and a printer's profile can set, too.
void parse_corrections(EngineSettings& engine, const SliceArgs& words) {
  const auto check = [](const char* name, double value, double least, double most) {
    // Negated, so that NaN is refused, too.
    if (!(value >= least && value <= most))
      throw UsageError(fmt::format("{} {}: expected {} to {}", name, value, least, most));
  };
  check("--grow-um", words.grow_um, -500, 500);
  check("--elephant-foot-um", words.elephant_foot_um, 0, 500);
  check("--elephant-foot-height-um", words.elephant_foot_height_um, 0, 10000);
  check("--gamma", words.gamma, 0.1, 10);
  check("--threshold", words.threshold, 0, 255);
  const auto foot_height = to_nanometers(to_millimeters(Micrometers{words.elephant_foot_height_um}));
  engine.compensation = {Micrometers{words.grow_um}, Micrometers{words.elephant_foot_um},
                         foot_height.value_or(Nanometers{})};
  engine.tone = {words.gamma, static_cast<std::uint8_t>(words.threshold)};
  if ((words.elephant_foot_um > 0) != (words.elephant_foot_height_um > 0))
    throw UsageError("--elephant-foot-um and --elephant-foot-height-um go together");
}

void check_corrections_go_with_masks(const SliceOptions& options) {
  const bool moves = options.engine.compensation != Compensation{};
  const bool corrects = moves || options.engine.tone != ToneCurve{} || options.uniformity;
  if (corrects && !options.mask && !options.masks) {
    throw UsageError(
        "--grow-um, --elephant-foot-um, --uniformity-mask, --gamma and --threshold change masks: they need "
        "--mask or --masks");
  }
  // With --fit, a micrometre of the part is not a micrometre of the picture.
  if (moves && options.fit) throw UsageError("--grow-um and --elephant-foot-um exclude --fit");
}

void set_if_given(std::optional<std::filesystem::path>& path, const std::string& word) {
  if (!word.empty()) path = word;
}

// Throws UsageError if the output is the model itself, so that a slip does not destroy the model.
void refuse_to_overwrite(const std::filesystem::path& model, const char* option,
                         const std::optional<std::filesystem::path>& output) {
  std::error_code ignored;  // a file that does not exist is not the model
  if (output && std::filesystem::equivalent(*output, model, ignored))
    throw UsageError(fmt::format("{} {}: this file is the model", option, output->string()));
}

AntiAliasing parse_anti_aliasing(const std::string& word) {
  return word == "on" ? AntiAliasing::On : AntiAliasing::Off;
}

// Parses a layer height, or a length that is compared with layer heights.
Nanometers parse_um(const char* option, double um, double least) {
  const auto length = to_nanometers(to_millimeters(Micrometers{um}));
  if (!length || !(um >= least) || *length > kThickestLayer) {
    throw UsageError(fmt::format("{} {}: expected {} to {:.0f}", option, um, least,
                                 to_millimeters(kThickestLayer).count() * 1000));
  }
  return *length;
}

AdaptiveLayers parse_adaptive(const SliceArgs& words) {
  const AdaptiveLayers layers{parse_um("--min-layer-um", words.min_layer_um, 1),
                              parse_um("--max-layer-um", words.max_layer_um, 1),
                              parse_um("--cusp-um", *words.cusp_um, 0.1)};
  if (layers.thinnest > layers.thickest) {
    throw UsageError(fmt::format("--min-layer-um {} is more than --max-layer-um {}", words.min_layer_um,
                                 words.max_layer_um));
  }
  return layers;
}

// Throws UsageError if the factor is outside the range that a ticket allows.
std::optional<double> parse_scale(const std::optional<double>& scale) {
  // Negated, so that NaN is refused, too.
  if (scale && !(*scale >= 0.001 && *scale <= 1000))
    throw UsageError(fmt::format("--scale {}: expected 0.001 to 1000", *scale));
  return scale;
}

SliceOptions parse_slice(SliceOptions options, const SliceArgs& words) {
  options.supports = words.supports == "auto";
  options.scale = parse_scale(words.scale);
  // Supports have sizes in millimetres, and a picture that fills the display has no scale.
  if (options.supports && options.fit) throw UsageError("--supports auto excludes --fit");
  if (words.up) options.up = parse_up(*words.up);
  options.engine.display = parse_display(words.display);
  options.engine.anti_aliasing = parse_anti_aliasing(words.anti_aliasing);
  parse_corrections(options.engine, words);
  set_if_given(options.uniformity, words.uniformity_mask);
  set_if_given(options.mask, words.mask);
  set_if_given(options.masks, words.masks);
  set_if_given(options.csv, words.csv);
  set_if_given(options.contours, words.contours);
  refuse_to_overwrite(options.model, "--mask", options.mask);
  refuse_to_overwrite(options.model, "--csv", options.csv);
  if (int{words.z_mm.has_value()} + int{words.layer_height_um.has_value()} + int{words.cusp_um.has_value()} !=
      1)
    throw UsageError("slice needs exactly one of --z, --layer-height-um and --cusp-um");
  if (words.z_mm) {
    if (!std::isfinite(*words.z_mm))
      throw UsageError(fmt::format("--z {}: expected a finite number", *words.z_mm));
    options.z = Millimeters{*words.z_mm};
    if (options.masks || options.csv || options.contours) {
      throw UsageError("--masks, --csv and --contours need --layer-height-um or --cusp-um");
    }
    if (options.force) throw UsageError("--force needs --masks or --contours");
    check_corrections_go_with_masks(options);
    return options;
  }
  if (options.force && !options.masks && !options.contours)
    throw UsageError("--force needs --masks or --contours");
  if (options.mask) throw UsageError("--mask needs --z");
  if (words.layer_height_um) options.layer_height = parse_um("--layer-height-um", *words.layer_height_um, 1);
  if (words.cusp_um) options.adaptive = parse_adaptive(words);
  check_corrections_go_with_masks(options);
  return options;
}

constexpr double kLongestLayerS = 3600;

SupportOptions parse_support(SupportOptions options, const SupportArgs& words) {
  if (words.up) options.up = parse_up(*words.up);
  options.display = parse_display(words.display);
  options.layer_height = parse_um("--layer-height-um", words.layer_height_um, 1);
  options.scale = parse_scale(words.scale);
  set_if_given(options.stl, words.stl);
  refuse_to_overwrite(options.model, "--stl", options.stl);
  if (options.with_model && !options.stl) throw UsageError("--with-model needs --stl");
  return options;
}

AnalyzeOptions parse_analyze(AnalyzeOptions options, const AnalyzeArgs& words) {
  if (words.up) options.up = parse_up(*words.up);
  options.display = parse_display(words.display);
  options.anti_aliasing = parse_anti_aliasing(words.anti_aliasing);
  options.layer_height = parse_um("--layer-height-um", words.layer_height_um, 1);
  // Negated, so that NaN is refused, too.
  if (!(words.layer_time_s >= 0 && words.layer_time_s <= kLongestLayerS))
    throw UsageError(fmt::format("--layer-time-s {}: expected 0 to {}", words.layer_time_s, kLongestLayerS));
  options.layer_time =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(words.layer_time_s));
  if (words.supports) options.supports = *words.supports == "auto" ? SupportPolicy::Auto : SupportPolicy::Off;
  options.scale = parse_scale(words.scale);
  set_if_given(options.html, words.html);
  refuse_to_overwrite(options.model, "--html", options.html);
  set_if_given(options.printer, words.printer);
  set_if_given(options.ticket, words.ticket);
  return options;
}

// Arguments of orient as the user typed them.
struct OrientArgs {
  std::string preset = "auto";
  std::string printer, resin, html, pictures;
};

OrientOptions parse_orient(OrientOptions options, const OrientArgs& words) {
  options.preset = orientation_preset(words.preset).value_or(OrientationPreset::Auto);
  options.scale = parse_scale(options.scale);
  if (options.force && words.pictures.empty()) throw UsageError("--force needs --pictures");
  set_if_given(options.printer, words.printer);
  set_if_given(options.resin, words.resin);
  set_if_given(options.html, words.html);
  refuse_to_overwrite(options.model, "--html", options.html);
  set_if_given(options.pictures, words.pictures);
  return options;
}

SubmitOptions parse_submit(SubmitOptions options, const std::optional<std::string>& up) {
  if (up) options.up = parse_up(*up);
  return options;
}

// Arguments of the manual commands as the user typed them.
struct ManualArgs {
  std::optional<double> to_mm, by_mm, speed_mm_s, seconds;
  bool plate_is_clear = false, in_resin = false, confirm = false, unhomed = false;
  ShowOptions show{.what = {}, .seconds = {}, .at_z_mm = {}, .printer = kDefaultConfig, .ticket = {}};
};

Request manual_request(const char* method, const ManualArgs& words) {
  Request request{method};
  const auto set = [&request](const char* name, const auto& word) {
    if (word) request.parameters[name] = *word;
  };
  const auto set_if = [&request](const char* name, bool word) {
    if (word) request.parameters[name] = true;
  };
  set("to_mm", words.to_mm);
  set("by_mm", words.by_mm);
  set("speed_mm_s", words.speed_mm_s);
  set("seconds", words.seconds);
  set_if("plate_is_clear", words.plate_is_clear);
  set_if("in_resin", words.in_resin);
  set_if("unhomed", words.unhomed);
  return request;
}

// Adds the options that say where the plate moves, and how fast.
void add_motion_options(CLI::App& move, ManualArgs& words) {
  CLI::Option* to = move.add_option("--to", words.to_mm, "Height above the film, mm");
  CLI::Option* by =
      move.add_option("--by", words.by_mm, "Distance upwards, mm; negative: downwards")->excludes(to);
  CLI::Option* speed =
      move.add_option("--speed", words.speed_mm_s, "Speed, mm/s (default: the configured travel speed)");
  move.add_flag("--unhomed", words.unhomed, "Move slowly, at most 2 mm, from an unknown position")
      ->needs(by)
      ->excludes(speed);
}

// Arguments of the commands for wiring and setting up a printer, as the user typed them.
struct WiringArgs {
  JogOptions jog;
  LevelOptions level;
  SetupOptions setup;
  bool once = false;
};

// Arguments of history, watch and replaced as the user typed them.
struct EndedArgs {
  HistoryOptions history;
  std::optional<std::string> job;
  std::string part;
};

// Arguments of the queue's commands as the user typed them.
struct QueueArgs {
  std::string job;
  int to = 1;
  bool first = false, last = false;
};

nlohmann::ordered_json place_in_queue(const QueueArgs& words) {
  if (words.last) return "last";
  return words.first ? 1 : words.to;
}

// Arguments of the commands that put models into the spool, as the user typed them.
struct SpoolArgs {
  SubmitOptions submit;
  std::optional<std::string> up;
  OfferOptions offer;
};

// Arguments of help and of the commands about contourd's computer, as the user typed them.
struct ComputerArgs {
  std::vector<std::string> help_command;
  LogsOptions logs;
  ConfigOptions config;
  DiagnoseOptions diagnosis;
};

// Refuses an empty argument: an unset shell variable must not become 0 or "no output".
const CLI::Validator kNotEmpty([](const std::string& word) { return word.empty() ? "it is empty" : ""; }, "");

// Help texts of options that several commands have.
constexpr const char* kUpHelp = "Direction that points up: X,Y,Z, or auto, fast, clean, safe";
constexpr const char* kPlateIsClearHelp = "Declare that nothing is in the plate's way";
constexpr const char* kSpoolHelp = "Spool folder, if contourd is not running";
constexpr const char* kAntiAliasingHelp = "Grey edges by area coverage (on), or 1-bit masks (off)";
constexpr const char* kPictureHelp = "Write a PNG file instead of drawing; - is standard output";
constexpr const char* kLikePrinterHelp = "Use this printer configuration, as contourd does";

// Returns the help text of the command with these words, or an empty string if there is no such command.
std::string help_of_command(const CLI::App& program, std::span<const std::string> words) {
  const CLI::App* command = &program;
  std::string before;
  for (const std::string& word : words) {
    before += (before.empty() ? "" : " ") + command->get_name();
    const auto is_called_so = [&word](const CLI::App* each) { return each->get_name() == word; };
    const std::vector<const CLI::App*> found = command->get_subcommands(is_called_so);
    if (found.empty()) return "";
    command = found.front();
  }
  // App::help() would describe the command that was parsed, which is help.
  const std::string name = before.empty() ? command->get_name() : before + ' ' + command->get_name();
  return command->get_formatter()->make_help(command, name, CLI::AppFormatMode::Normal);
}

// Command line parser: defines the commands and their options, and runs the chosen command. It has many
// functions: one for each command.
class CommandLine {
 public:
  CommandLine() {
    app_.require_subcommand(1);
    app_.set_version_flag("--version", CONTOURD_VERSION);
    const char* socket = std::getenv("CONTOURD_SOCKET");
    client_.socket = socket != nullptr ? socket : kDefaultSocket;
    add_inspect();
    add_slice();
    add_analyze();
    add_support();
    add_orient();
    add_preview();
    add_mask();
    add_submit();
    add_offer();
    add_client_commands();
    add_logs();
    add_config_commands();
    add_diagnose();
    add_manual_commands();
    add_help();
  }
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  int run(int argc, char** argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return end_of_command_line(app_, error);
    }
    return chosen_();
  }

 private:
  CLI::App* add_command(const char* name, const char* help, std::function<int()> call) {
    return add_command(&app_, name, help, std::move(call));
  }
  CLI::App* add_command(CLI::App* parent, const char* name, const char* help, std::function<int()> call) {
    CLI::App* command = parent->add_subcommand(name, help);
    command->callback([this, call = std::move(call)] { chosen_ = call; });
    return command;
  }

  // Adds a group of commands, one of which has to be chosen.
  CLI::App* add_group(const char* name, const char* help) {
    CLI::App* group = app_.add_subcommand(name, help);
    group->require_subcommand(1);
    return group;
  }

  void add_inspect() {
    CLI::App* command = add_command("inspect", "Show the contents and defects of a model file",
                                    [this] { return inspect(inspect_); });
    command->add_option("MODEL", inspect_.model, "Model file")->required();
    command->add_flag("--json", inspect_.json, "Print JSON");
  }

  void add_slice() {
    CLI::App* command = add_command("slice", "Slice a model at one height or into layers",
                                    [this] { return slice(parse_slice(slice_, words_)); });
    command->add_option("MODEL", slice_.model, "Model file")->required();
    const auto add = [command](const char* name, auto& word, const char* help) {
      return command->add_option(name, word, help)->check(kNotEmpty)->capture_default_str();
    };
    add("--z", words_.z_mm, "Height of the cut, mm, in the file's coordinates");
    add("--up", words_.up, kUpHelp);
    add("--layer-height-um", words_.layer_height_um, "Layer height, um");
    CLI::Option* cusp =
        add("--cusp-um", words_.cusp_um, "Adaptive layers: maximum distance of an edge from the surface, um");
    add("--min-layer-um", words_.min_layer_um, "Thinnest adaptive layer, um")->needs(cusp);
    add("--max-layer-um", words_.max_layer_um, "Thickest adaptive layer, um")->needs(cusp);
    add("--mask", words_.mask, "Write the mask at --z to this PNG file");
    add("--masks", words_.masks, "Write one PNG file per layer to this folder: 0001.png ...");
    add("--csv", words_.csv, "Write layer measurements to this file, and FILE-summary.csv");
    add("--contours", words_.contours, "Write one CSV file of contour points per layer to this folder");
    add("--display", words_.display.display, "Display size in pixels, WIDTHxHEIGHT");
    add("--pixel-pitch-um", words_.display.pixel_pitch_um, "Side of a pixel on the plate, um");
    add("--aa", words_.anti_aliasing, kAntiAliasingHelp)->check(CLI::IsMember({"on", "off"}));
    add("--grow-um", words_.grow_um, "Move the contours outwards, um; negative: inwards");
    add("--elephant-foot-um", words_.elephant_foot_um, "Move the contours inwards at the bottom, um");
    add("--elephant-foot-height-um", words_.elephant_foot_height_um,
        "Height over which the elephant foot correction fades, um");
    add("--uniformity-mask", words_.uniformity_mask,
        "Multiply the masks by this 8-bit grey PNG file; 255 is 1");
    add("--supports", words_.supports, "Generate supports: auto or off")
        ->check(CLI::IsMember({"auto", "off"}));
    add("--scale", words_.scale, "Scale the model by this factor");
    add("--gamma", words_.gamma, "Gamma of the projector, which the masks undo");
    add("--threshold", words_.threshold, "Make grey below this value black");
    command->add_flag("--force", slice_.force, "Replace the files of an earlier slice");
    command->add_flag("--fit", slice_.fit, "Scale the model to fill the display");
    command->add_flag("--json", slice_.json, "Print JSON");
  }

  void add_analyze() {
    CLI::App* command = add_command("analyze", "Forecast a whole print: resin, areas, islands, times",
                                    [this] { return analyze(parse_analyze(analyze_, analyze_words_)); });
    command->add_option("MODEL", analyze_.model, "Model file")->required();
    command->add_flag("--json", analyze_.json, "Print JSON");
    command->add_option("--html", analyze_words_.html, "Write a page with plots and a picture")
        ->check(kNotEmpty);
    CLI::Option* printer =
        command->add_option("--printer", analyze_words_.printer, kLikePrinterHelp)->check(kNotEmpty);
    command->add_option("--ticket", analyze_words_.ticket, "Ticket of the job")
        ->check(kNotEmpty)
        ->needs(printer);
    command
        ->add_option("--supports", analyze_words_.supports,
                     "Generate supports: auto or off (default: as configured, or off)")
        ->check(CLI::IsMember({"auto", "off"}));
    command->add_option("--scale", analyze_words_.scale, "Scale the model by this factor")->check(kNotEmpty);
    const auto add = [&](const char* name, auto& word, const char* help) {
      return command->add_option(name, word, help)
          ->check(kNotEmpty)
          ->capture_default_str()
          ->excludes(printer);
    };
    add("--up", analyze_words_.up, kUpHelp);
    add("--layer-height-um", analyze_words_.layer_height_um, "Layer height, um");
    add("--layer-time-s", analyze_words_.layer_time_s, "Time that the printer needs per layer, s");
    add("--display", analyze_words_.display.display, "Display size in pixels, WIDTHxHEIGHT");
    add("--pixel-pitch-um", analyze_words_.display.pixel_pitch_um, "Side of a pixel on the plate, um");
    add("--aa", analyze_words_.anti_aliasing, kAntiAliasingHelp)->check(CLI::IsMember({"on", "off"}));
  }

  void add_support() {
    CLI::App* command = add_command("support", "Generate supports and report what they hold",
                                    [this] { return support(parse_support(support_, support_words_)); });
    command->add_option("MODEL", support_.model, "Model file")->required();
    const auto add = [command](const char* name, auto& word, const char* help) {
      return command->add_option(name, word, help)->check(kNotEmpty)->capture_default_str();
    };
    add("--stl", support_words_.stl, "Write the supports to this STL file");
    command->add_flag("--with-model", support_.with_model, "Write the lifted model to the STL file, too");
    add("--scale", support_words_.scale, "Scale the model by this factor");
    add("--up", support_words_.up, kUpHelp);
    add("--layer-height-um", support_words_.layer_height_um,
        "Layer height, um; the model is lifted by whole layers");
    add("--display", support_words_.display.display, "Build area in pixels, WIDTHxHEIGHT");
    add("--pixel-pitch-um", support_words_.display.pixel_pitch_um, "Side of a pixel on the plate, um");
    command->add_flag("--json", support_.json, "Print JSON");
  }

  void add_orient() {
    CLI::App* command = add_command("orient", "Find the orientation in which a model prints best",
                                    [this] { return orient(parse_orient(orient_, orient_words_)); });
    command->add_option("MODEL", orient_.model, "Model file")->required();
    const auto add = [command](const char* name, auto& word, const char* help) {
      return command->add_option(name, word, help)->check(kNotEmpty)->capture_default_str();
    };
    add("--preset", orient_words_.preset, "Weights: auto (from the resin's profile), fast, clean or safe")
        ->check(CLI::IsMember({"auto", "fast", "clean", "safe"}));
    add("--scale", orient_.scale, "Scale the model by this factor");
    add("--printer", orient_words_.printer, kLikePrinterHelp);
    add("--profile", orient_words_.resin, "Resin profile, instead of the printer's resin");
    add("--html", orient_words_.html, "Write a page with pictures");
    add("--pictures", orient_words_.pictures, "Write one PNG picture per orientation to this folder");
    command->add_flag("--force", orient_.force, "Replace the pictures of an earlier call");
    command->add_flag("--json", orient_.json, "Print JSON");
  }

  void add_mask() {
    CLI::App* command = add_command("mask", "Show the picture on the display: the mask of the current layer",
                                    [this] { return mask(client_, preview_.output); });
    command->add_option("-o,--output", preview_.output, kPictureHelp)->check(kNotEmpty);
    add_socket_option(command);
  }

  void add_preview() {
    CLI::App* command = add_command("preview", "Draw a model or a job of the spool",
                                    [this] { return preview(client_, preview_); });
    command->add_option("JOB", preview_.subject, "Name of a job, or model file")
        ->required()
        ->check(kNotEmpty);
    command->add_option("--layer", preview_.layer, "Draw the mask of this layer, counted from 1")
        ->check(CLI::Range(1, kMaxLayers));
    const auto add = [command](const char* name, auto& option, const char* help) {
      command->add_option(name, option, help)->check(kNotEmpty);
    };
    add("--printer", preview_.printer, kLikePrinterHelp);
    add("--ticket", preview_.ticket, "Ticket for the model file");
    add("-o,--output", preview_.output, kPictureHelp);
    add("--spool", preview_.spool, kSpoolHelp);
    add_socket_option(command);
  }

  void add_submit() {
    CLI::App* command = add_command("submit", "Add models to the queue", [this] {
      return submit(client_, parse_submit(spool_.submit, spool_.up));
    });
    command->add_option("FILE", spool_.submit.models, "Model files")->required();
    CLI::Option* ticket =
        command->add_option("--ticket", spool_.submit.ticket, "Ticket for all models")->check(kNotEmpty);
    const auto add = [&](const char* name, auto& option, const char* help) {
      return command->add_option(name, option, help)->excludes(ticket);
    };
    add("--resin", spool_.submit.resin, "Name of the resin profile")->check(kNotEmpty);
    add("--layer-height-um", spool_.submit.layer_height_um, "Layer height, um");
    add("--exposure-ms", spool_.submit.exposure_ms, "Exposure of a normal layer, ms, within ticket_limits");
    add("--bottom-exposure-ms", spool_.submit.bottom_exposure_ms,
        "Exposure of a bottom layer, ms, within ticket_limits");
    add("--lift-mm", spool_.submit.lift_mm, "Lift after an exposure, mm, within ticket_limits");
    add("--settle-ms", spool_.submit.settle_ms, "Wait before the exposure, ms, within ticket_limits");
    add("--rest-ms", spool_.submit.rest_ms, "Wait after the exposure, ms, within ticket_limits");
    add("--copies", spool_.submit.copies, "Number of copies of each model");
    add("--up", spool_.up, kUpHelp)->check(kNotEmpty);
    add("--supports", spool_.submit.supports, "Generate supports: auto or off (default: as configured)")
        ->check(CLI::IsMember({"auto", "off"}));
    CLI::Option* scale = add("--scale", spool_.submit.scale, "Scale the model by this factor");
    command->add_flag("--fit", spool_.submit.fit, "Scale the model to fill the display")
        ->excludes(ticket)
        ->excludes(scale);
    command
        ->add_option("--printer", spool_.submit.printer,
                     "Forecast and check the print with this printer configuration")
        ->check(kNotEmpty);
    command->add_option("--spool", spool_.submit.spool, kSpoolHelp)->check(kNotEmpty);
    command->add_flag("--wait", spool_.submit.wait, "Wait until all jobs have ended");
    command->add_flag("--yes", spool_.submit.yes, "Do not ask for confirmation of warnings");
    add_client_options(command);
  }

  void add_offer() {
    CLI::App* command =
        add_command("offer", "Add the models of an untrusted folder (a USB stick) to the queue",
                    [this] { return offer(client_, spool_.offer); });
    command->add_option("FOLDER", spool_.offer.folder, "Folder with models; links in it are not followed")
        ->required()
        ->check(kNotEmpty);
    command->add_option("--spool", spool_.offer.spool, kSpoolHelp)->check(kNotEmpty);
    CLI::Option* once = command
                            ->add_option("--once", spool_.offer.once,
                                         "Take each file only once; keep the record in this file")
                            ->check(kNotEmpty);
    command->add_option("--label", spool_.offer.label, "Name that distinguishes this folder in that record")
        ->needs(once);
    add_client_options(command);
  }

  void add_help() {
    CLI::App* command = add_command("help", "Show the manual page, or the usage of a command", [this] {
      return help(computer_.help_command,
                  [this](std::span<const std::string> words) { return help_of_command(app_, words); });
    });
    command->add_option("COMMAND", computer_.help_command, "Show the usage of this command");
  }

  void add_client_commands() {
    add_client("status", "Show the current activity of the printer", "status");
    add_queue_commands();
    add_accept();
    add_history();
    add_client("usage", "Show hours of light, layers and resin so far", "usage", print_usage);
    CLI::App* replaced =
        add_command("replaced", "Record that the lamp, the film or the vat was replaced", [this] {
          return request(client_, {"replaced", {{"part", ended_.part}}}, print_usage);
        });
    replaced->add_option("PART", ended_.part, "Replaced part: lamp, film or vat")
        ->required()
        ->check(CLI::IsMember({"lamp", "film", "vat"}));
    add_client_options(replaced);
    add_client("pause", "Pause the print after the current layer", "pause");
    add_client("resume", "Continue after a pause, or release the queue after a failure", "resume");
    add_client("cancel", "Cancel the current print: light off, plate up", "cancel");
    add_client("plate-cleared", "Confirm that the plate is free for the next job", "plate_cleared");
    CLI::App* command =
        add_command("watch", "Follow the print until it ends", [this] { return watch(client_, ended_.job); });
    command->add_option("--job", ended_.job, "Follow until this job has ended")->check(kNotEmpty);
    add_client_options(command);
  }

  void add_queue_commands() {
    CLI::App* queue = app_.add_subcommand("queue", "List the waiting jobs, or show, remove or move one");
    // CLI11 calls this after the callback of a subcommand.
    queue->callback([this, queue] {
      if (queue->get_subcommands().empty())
        chosen_ = [this] { return request(client_, {"queue"}, print_queue); };
    });
    add_client_options(queue);
    const auto add = [this, queue](const char* name, const char* help, std::function<int()> call) {
      CLI::App* command = add_command(queue, name, help, std::move(call));
      command->add_option("JOB", queue_.job, "Name of the job, or of its file in incoming")
          ->required()
          ->check(kNotEmpty);
      add_client_options(command);
      return command;
    };
    add("show", "Show the details of a waiting job", [this] {
      return request(client_, {"queue", {{"job", queue_.job}}}, print_waiting_job);
    });
    add("remove", "Remove a job from the queue; its files go to failed",
        [this] { return remove_from_queue(client_, queue_.job); });
    CLI::App* move = add("move", "Move a job within the queue", [this] {
      return request(client_, {"queue_move", {{"job", queue_.job}, {"to", place_in_queue(queue_)}}},
                     print_queue);
    });
    CLI::Option_group* place = move->add_option_group("Place");
    place->require_option(1);
    place->add_option("--to", queue_.to, "Move to this place, counted from 1")->check(CLI::Range(1, 1000));
    place->add_flag("--first", queue_.first, "Move to the start of the queue");
    place->add_flag("--last", queue_.last, "Move to the end of the queue");
  }

  void add_accept() {
    CLI::App* command = add_command("accept", "Accept a job that is waiting for confirmation",
                                    [this] { return accept_job(client_, queue_.job); });
    command->add_option("JOB", queue_.job, "Name of the job, or of its file in incoming")
        ->required()
        ->check(kNotEmpty);
    add_client_options(command);
  }

  void add_logs() {
    CLI::App* command = add_command("logs", "Show contourd's entries in the journal",
                                    [this] { return logs(computer_.logs); });
    command->add_option("JOB", computer_.logs.job, "Show only entries about this job")->check(kNotEmpty);
    command
        ->add_option("-n,--lines", computer_.logs.lines,
                     "Show the latest N lines (default without a job: 100)")
        ->check(CLI::Range(1, 1'000'000));
    command->add_flag("-f,--follow", computer_.logs.follow, "Keep printing new lines");
  }

  void add_config_commands() {
    CLI::App* config = add_group("config", "Check and show the printer's configuration");
    const auto add = [this, config](const char* name, const char* help, int (*call)(const ConfigOptions&)) {
      return add_command(config, name, help, [this, call] { return call(computer_.config); });
    };
    const auto add_file = [this](CLI::App* command) {
      command->add_option("FILE", computer_.config.file, "Configuration file")
          ->capture_default_str()
          ->check(kNotEmpty);
    };
    add_file(add("check", "List mistakes in it, as contourd --check-config does", config_check));
    add_file(add("show", "Print it with all defaults, as JSON", config_show));
    add_file(add("diff", "Print the values that differ from their defaults", config_diff));
    add("schema", "Print the JSON schema of a file format", config_schema)
        ->add_option("FORMAT", computer_.config.format,
                     "File format: printer, resin, projector, ticket or plate")
        ->capture_default_str()
        ->check(CLI::IsMember(config_formats()));
  }

  void add_diagnose() {
    CLI::App* command = add_command("diagnose", "Collect information for a bug report in one archive",
                                    [this] { return diagnose(client_, computer_.diagnosis); });
    command
        ->add_option("JOB", computer_.diagnosis.job,
                     "Include the report and journal of this job (default: the latest)")
        ->check(kNotEmpty);
    command
        ->add_option("-o,--output", computer_.diagnosis.output, "Archive to create (.tar.gz); must not exist")
        ->check(kNotEmpty);
    command->add_option("--config", computer_.diagnosis.config, "Configuration of the printer")
        ->capture_default_str()
        ->check(kNotEmpty);
    add_socket_option(command);
  }

  void add_history() {
    CLI::App* command = add_command("history", "List the outcomes of the latest jobs",
                                    [this] { return history(client_, ended_.history); });
    command->add_option("--last", ended_.history.last, "Show at most N jobs")
        ->check(CLI::Range(1, kLongestHistory))
        ->capture_default_str();
    const auto add = [command](const char* name, std::string& word, const char* help) {
      return command->add_option(name, word, help)->check(kNotEmpty);
    };
    add("--since", ended_.history.since, "Show jobs that ended since DATE, or in the last 7d or 12h");
    add("--outcome", ended_.history.outcome, "Show jobs with this outcome")
        ->check(CLI::IsMember({"done", "failed", "cancelled"}));
    add("--resin", ended_.history.resin, "Show jobs that were printed with this resin");
    add("--job", ended_.history.job, "Show jobs with this text in their names");
    command->add_flag("--csv", ended_.history.csv, "Print CSV, one line per job, for a spreadsheet");
    add_client_options(command);
  }

  // Adds the commands for manual control, which work only while no job is printed.
  void add_manual_commands() {
    const auto by_hand = [this](CLI::App* parent, const char* name, const char* help, const char* method,
                                WaitFor what = WaitFor::Operation) {
      CLI::App* command = add_command(parent, name, help, [this, method, what] {
        return control_by_hand(client_, manual_request(method, manual_), what);
      });
      add_client_options(command);
      return command;
    };
    const auto add_plate_is_clear = [this](CLI::App* command) {
      command->add_flag("--plate-is-clear", manual_.plate_is_clear, kPlateIsClearHelp);
    };
    add_plate_is_clear(by_hand(&app_, "home", "Home the plate: move it to its limit switch", "home"));
    CLI::App* move = by_hand(&app_, "move", "Move the plate", "move");
    add_motion_options(*move, manual_);
    add_plate_is_clear(move);
    by_hand(&app_, "stop", "Stop manual control: motor still, light off, screen black", "stop",
            WaitFor::Rest);
    by_hand(add_group("motor", "Control the plate's motor"), "off", "Turn off the motor's current",
            "motor_off");
    CLI::App* light = add_group("light", "Control the projector's light");
    CLI::App* on = add_command(light, "on", "Turn the light on, with the current picture", [this] {
      return light_by_hand(client_, manual_request("light_on", manual_), manual_.confirm);
    });
    on->add_option("--seconds", manual_.seconds, "Duration, s")->required();
    on->add_flag("--confirm", manual_.confirm, "Do not ask whether eyes are protected");
    on->add_flag("--in-resin", manual_.in_resin, "Allow light while the plate may be in the resin");
    add_client_options(on);
    by_hand(light, "off", "Turn the light off", "light_off", WaitFor::Rest);
    CLI::App* show = add_command(&app_, "show", "Show a test pattern or a picture until interrupted",
                                 [this] { return show_by_hand(client_, manual_.show); });
    show->add_option("PATTERN", manual_.show.what,
                     "white, black, grid, checker, focus, border, dimensions; a PNG file of the display's "
                     "size; or a model file")
        ->required()
        ->check(kNotEmpty);
    show->add_option("--seconds", manual_.show.seconds, "Duration, s");
    CLI::Option* at_z = show->add_option("--at-z", manual_.show.at_z_mm,
                                         "Show the mask of a model file at this height above the plate, mm");
    show->add_option("--printer", manual_.show.printer, kLikePrinterHelp)
        ->capture_default_str()
        ->check(kNotEmpty)
        ->needs(at_z);
    show->add_option("--ticket", manual_.show.ticket, "Ticket for the model file")
        ->check(kNotEmpty)
        ->needs(at_z);
    add_client_options(show);
    CLI::App* projector = add_group("projector", "Control the projector's power");
    by_hand(projector, "status", "Show the projector's state", "projector");
    const auto power = [&, this](const char* word, const char* help) {
      add_client_options(add_command(projector, word, help, [this, word] {
        return power_projector(client_, word == std::string_view("on"));
      }));
    };
    power("on", "Turn the projector on and wait until it is warm; the light stays off");
    power("off", "Turn the projector off");
    add_wiring_commands();
  }

  // Adds the commands for wiring and setting up a printer.
  void add_wiring_commands() {
    CLI::App* switches = add_command(&app_, "switches", "Show the states of switches and other inputs, live",
                                     [this] { return show_switches(client_, wiring_.once); });
    switches->add_flag("--once", wiring_.once, "Print the states once");
    add_client_options(switches);
    CLI::App* jog_keys =
        add_command(&app_, "jog", "Move the plate by keys", [this] { return jog(client_, wiring_.jog); });
    jog_keys->add_option("--light-seconds", wiring_.jog.light_s, "Duration of the light of the key l, s")
        ->capture_default_str();
    jog_keys->add_flag("--plate-is-clear", wiring_.jog.plate_is_clear, kPlateIsClearHelp);
    jog_keys->add_flag("--in-resin", wiring_.jog.in_resin, "Allow light while the plate may be in the resin");
    add_socket_option(jog_keys);
    CLI::App* levelling =
        add_command(&app_, "level", "Level the plate, step by step, and store the height of its switch",
                    [this] { return level(client_, wiring_.level); });
    levelling->add_option("--config", wiring_.level.config, "Configuration of the printer")
        ->capture_default_str();
    add_socket_option(levelling);
    add_setup();
  }

  void add_setup() {
    SetupOptions& options = wiring_.setup;
    CLI::App* command =
        add_command(&app_, "setup", "Set up a wired printer, step by step, and write its configuration",
                    [this] { return setup(client_, wiring_.setup); });
    command->add_option("--config", options.config, "Configuration to write")
        ->capture_default_str()
        ->check(kNotEmpty);
    command->add_flag("--non-interactive", options.non_interactive,
                      "Ask nothing: use the given answers and safe suggestions");
    command->add_option("--set", options.set, "Answer as KEY=VALUE; can be repeated")
        ->allow_extra_args(false);
    command->add_option("--answers", options.answers, "Read answers from this JSON file")->check(kNotEmpty);
    command->add_flag("--restart", options.restart, "Discard the answers of earlier calls");
    command->add_flag("--replace", options.replace,
                      "Replace an edited configuration without asking (a copy is kept)");
    add_socket_option(command);
  }

  // Adds a command that calls a method without parameters.
  void add_client(const char* name, const char* help, const char* method,
                  decltype(&print_status) print = print_status) {
    add_client_options(
        add_command(name, help, [this, method, print] { return request(client_, {method}, print); }));
  }

  void add_socket_option(CLI::App* command) {
    command->add_option("--socket", client_.socket, "Control socket of contourd (or CONTOURD_SOCKET)")
        ->capture_default_str()
        ->check(kNotEmpty);
  }

  void add_client_options(CLI::App* command) {
    add_socket_option(command);
    command->add_flag("--json", client_.json, "Print JSON, one message per line");
  }

  CLI::App app_{"Inspects and slices models, and controls contourd, the daemon of a resin printer."};
  InspectOptions inspect_;
  SliceOptions slice_;
  AnalyzeOptions analyze_;
  AnalyzeArgs analyze_words_;
  SupportOptions support_;
  SupportArgs support_words_;
  SliceArgs words_;
  OrientOptions orient_;
  OrientArgs orient_words_;
  PreviewOptions preview_;
  SpoolArgs spool_;
  ManualArgs manual_;
  WiringArgs wiring_;
  QueueArgs queue_;
  ComputerArgs computer_;
  ClientOptions client_;
  EndedArgs ended_;
  std::function<int()> chosen_;
};

// Prints the error as one line, even if a file's name contains line breaks. Returns the exit code.
int complain(int code, const char* why) {
  std::string line = why;
  std::ranges::replace(line, '\n', ' ');
  fmt::print(stderr, "contourctl: {}\n", printable(line));
  return code;
}

}  // namespace
}  // namespace contourd::ctl

int main(int argc, char** argv) {
  using namespace contourd::ctl;
  try {
    return contourd::print_whole([&] { return CommandLine().run(argc, argv); });
  } catch (const UsageError& error) {
    return complain(contourd::kBadUsage, error.what());
  } catch (const contourd::ModelError& error) {
    return complain(kBadData, error.what());
  } catch (const contourd::TooManyLayers& error) {
    return complain(kBadData, error.what());
  } catch (const contourd::OutputError& error) {
    return complain(contourd::kCannotCreate, error.what());
  } catch (const contourd::ConfigError& error) {
    return complain(kBadConfig, error.what());
  } catch (const contourd::ProfileTrouble& error) {
    return complain(kBadConfig, error.sentence().c_str());
  } catch (const contourd::DaemonError& error) {
    return complain(kUnavailable, error.what());
  } catch (const std::system_error& error) {
    return complain(kNoInput, error.what());
  } catch (const std::bad_alloc&) {
    return complain(kBadData, "the model does not fit into this machine's memory");
  } catch (const std::exception& error) {
    return complain(kFailed, error.what());
  }
}
