#include "daemon/ctl/setup/setup_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/client/control_defaults.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/projector_table.hpp"
#include "daemon/ctl/commands/machine_facts.hpp"
#include "daemon/ctl/setup/setup_checks.hpp"
#include "daemon/ctl/setup/setup_dialog.hpp"
#include "daemon/ctl/setup/setup_profile.hpp"
#include "daemon/ctl/setup/setup_record.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd::ctl {
namespace {

struct SetupOptions {
  std::filesystem::path config = kDefaultConfig;
  std::optional<std::filesystem::path> answers;  // JSON file with answers
  std::vector<std::string> set;                  // KEY=VALUE
  bool non_interactive = false;
  bool restart = false;  // discard the answers of earlier calls
  bool replace = false;  // replace an edited configuration without asking
};

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kShipped = "/usr/share/contourd";

constexpr std::size_t kLargestBytes = 2'000'000;

std::string bytes_of(const fs::path& file) {
  try {
    return beginning_of(file, kLargestBytes, Links::Follow);
  } catch (const UnreadableFile& error) {
    throw UnreadableFile(error.code(), fmt::format("{}: {}", file.string(), error.what()));
  }
}

// Returns the folder with this name for a new configuration: next to the configuration if there is one, else
// in /etc/contourd, else the one installed with the program.
std::string folder_for(const fs::path& config, const char* name) {
  std::error_code none;
  for (const fs::path& folder : {fs::path("/etc/contourd"), fs::path(kShipped)}) {
    if (fs::is_directory(config.parent_path() / name, none)) break;
    if (fs::is_directory(folder / name, none)) return (folder / name).string();
  }
  return name;
}

// Returns a simulated printer as the starting point if there is no configuration.
Json new_profile(const fs::path& config) {
  return {{"$schema", "contourd.schema.json"},
          {"name", "Resin printer"},
          {"spool_folder", "/var/spool/contourd"},
          {"control_socket", kDefaultSocket},
          {"resins_folder", folder_for(config, "resins")},
          {"projectors_folder", folder_for(config, "projectors")},
          {"resin", "standard"},
          {"wait_for_plate_cleared", true},
          {"z_axis",
           {{"travel_mm", 160},
            {"microsteps_per_mm", 800},
            {"homing_speed_mm_s", 5},
            {"travel_speed_mm_s", 5},
            {"acceleration_mm_s2", 25}}},
          {"display", {{"width_px", 1920}, {"height_px", 1080}, {"pixel_pitch_um", 50}, {"refresh_hz", 60}}},
          {"projector", {{"irradiance_mw_cm2", 5}, {"warm_up_s", 30}}},
          {"hardware", "simulated"},
          {"simulation", {{"pace", "realtime"}}}};
}

class Setup {
 public:
  Setup(const ClientOptions& client, const SetupOptions& options)
      : client_(client), options_(options), file_(fs::weakly_canonical(fs::absolute(options.config))) {
    const fs::path folder = file_.parent_path(), stem = file_.stem();
    record_file_ = folder / (stem.string() + ".setup.json");
    notes_file_ = folder / (stem.string() + ".setup.txt");
  }

  int run() {
    require_folder();
    read_configuration();
    facts_ = {find_devices(), find_tables(), given_name()};
    read_record();
    take_given();
    dialog_.say("Devices found:");
    for (const std::string& line : describe(facts_.devices))
      dialog_.say("  " + line, 4);
    try {
      return options_.non_interactive ? decide() : lead();
    } catch (const DialogLeft&) {
      fmt::print("\n");
      dialog_.say(record_.answers.empty()
                      ? "Quit without answers."
                      : fmt::format("Quit. {} continues from here; the answers are in {}.", command(),
                                    record_file_.string()));
      return kFailed;
    } catch (const std::system_error& error) {  // all that is read has been read
      throw OutputError(fmt::format("setup: {}", error.what()));
    }
  }

 private:
  // Returns the configured name of a real printer. The name of a simulated printer does not count.
  [[nodiscard]] std::string given_name() const {
    return base_.value("hardware", "") == "real" ? base_.value("name", "") : "";
  }

  void require_folder() const {
    if (::access(file_.parent_path().c_str(), W_OK) != 0)
      throw OutputError(
          fmt::format("setup: cannot write into {}: {}; use sudo contourctl setup, or --config FILE",
                      file_.parent_path().string(), std::strerror(errno)));
  }
  int decide() {
    take_suggestions();
    print_summary();
    write();
    return kOk;
  }
  [[nodiscard]] std::string command() const {
    return file_ == kDefaultConfig ? "contourctl setup"
                                   : fmt::format("contourctl setup --config {}", file_.string());
  }

  void keep() const { write_setup_record(record_file_, record_); }

  // --- devices and files

  void read_configuration() {
    std::error_code none;
    base_ = new_profile(file_);
    if (!fs::exists(file_, none)) return;
    before_ = bytes_of(file_);
    try {
      (void)load_printer_config(file_);
      base_ = Json::parse(*before_);
    } catch (const ConfigError& error) {
      dialog_.say(fmt::format("{}. Setup starts from the defaults instead.", first_line(error.what())));
    }
  }
  static std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

  [[nodiscard]] std::map<std::string, bool> find_tables() const {
    std::map<std::string, bool> tables;
    const fs::path folder = resolved(file_.parent_path(), base_.value("projectors_folder", "projectors"));
    try {
      for (const std::string& name : profiles_in(folder)) {
        try {
          tables[name] = load_projector_table(folder / (name + ".json")).switches_light();
        } catch (const ConfigError& error) {
          dialog_.say(first_line(error.what()) + ". This table is ignored.");
        }
      }
    } catch (const std::system_error& error) {
      dialog_.say(fmt::format("No projector tables were found: {}.", error.what()));
    }
    return tables;
  }

  void read_record() {
    std::error_code none;
    if (options_.restart || !fs::exists(record_file_, none)) return;
    record_ = read_setup_record(record_file_);
    dialog_.say(fmt::format("Continuing with {} answers; --restart discards them. They are in {}.",
                            record_.answers.size(), record_file_.string()));
  }

  // --- answers without questions

  void take_given() {
    Answers given;
    if (options_.answers) given = read_setup_record(*options_.answers).answers;
    for (const std::string& word : options_.set) {
      const std::size_t sign = word.find('=');
      const std::string key = word.substr(0, sign);
      if (sign == std::string::npos || find_question(key) == nullptr)
        throw UsageError(fmt::format("setup: --set {}: expected KEY=VALUE with one of the keys {}", word,
                                     question_keys()));
      given[key] = word.substr(sign + 1);
    }
    for (const auto& [key, answer] : given)
      record_.answers[key] = answer;
    if (given.empty()) return;
    Answers answers = record_.answers;
    (void)complete(answers, [&given](const std::string& key) { return given.contains(key); });
  }
  // Completes the answers in the order of the questions by the suggestions. Devices are not compared with
  // those of this computer, because the answers may be for another one. Throws UsageError if an answer whose
  // key `must_be_valid` names is not valid; the suggestion replaces any other one. Returns the keys of
  // questions without an answer and without a safe default.
  template <typename Names>
  std::vector<std::string> complete(Answers& answers, Names must_be_valid) const {
    const SetupFacts elsewhere{.devices = {}, .tables = facts_.tables};
    std::vector<std::string> unknown;
    for (const Question& question : questions()) {
      if (!question.is_asked(answers, facts_)) continue;
      const std::string key(question.key);
      const Suggestion suggestion = question.suggest(answers, facts_);
      if (!answers.contains(key) && !suggestion.safe) unknown.push_back(key);
      const std::string answer = answers.contains(key) ? answers[key] : suggestion.answer;
      const TakenAnswer taken = question.take(answer, answers, elsewhere);
      const bool is_valid = taken.complaint.empty();
      if (!is_valid && must_be_valid(key))
        throw UsageError(fmt::format("setup: {} = {}: {}", key, in_quotes(answer), taken.complaint));
      answers[key] = is_valid ? taken.answer : suggestion.answer;
    }
    return unknown;
  }

  void take_suggestions() {
    const std::vector<std::string> unknown =
        complete(record_.answers, [](const std::string&) { return true; });
    if (unknown.empty()) return;
    throw UsageError(
        fmt::format("setup: no default is safe for {}: give an answer for each by --set KEY=VALUE, or in the "
                    "file of --answers",
                    fmt::join(unknown, ", ")));
  }

  // --- dialog

  int lead() {
    dialog_.say(
        "Enter accepts the suggestion, ? shows the possible answers, back returns to the previous question, "
        "quit leaves. Each answer is saved: after quit, Ctrl-C or a lost terminal, the next call continues "
        "here.");
    const auto keep = [this] { this->keep(); };
    dialog_.answer_all(record_.answers, facts_, keep);
    while (true) {
      print_summary();
      const std::string key = dialog_.ask(
          prompt_to_write(), "Expected a key above, Enter, back to answer the last question again, or quit.");
      if (key.empty()) {
        if (write()) break;
      } else if (key == "back") {
        dialog_.answer_again(explained(record_.answers, facts_).back().key, record_.answers, facts_, keep);
      } else if (find_question(key) != nullptr && find_question(key)->is_asked(record_.answers, facts_)) {
        dialog_.answer_again(key, record_.answers, facts_, keep);
      } else {
        dialog_.say("This is not one of the keys above.");
      }
    }
    return check();
  }
  [[nodiscard]] std::string prompt_to_write() const {
    const std::string changes = "Type a key to answer its question again.";
    if (is_up_to_date()) return fmt::format("{} Enter: {} is up to date, continue:", changes, file_.string());
    if (!before_) return fmt::format("{} Enter: write {}:", changes, file_.string());
    return fmt::format("{} Enter: replace {} and keep a copy:", changes, file_.string());
  }

  // True if the file has the configuration that would be written, in any formatting.
  [[nodiscard]] bool is_up_to_date() const {
    if (!before_) return false;
    const nlohmann::json before = nlohmann::json::parse(*before_, nullptr, false);
    return before == nlohmann::json::parse(text());
  }
  [[nodiscard]] std::string text() const {
    using Handler = Json::error_handler_t;
    return profile_of(asked_answers(record_.answers, facts_), base_).dump(2, ' ', false, Handler::replace) +
           "\n";
  }

  void print_summary() const {
    fmt::print("\n");
    for (const ExplainedAnswer& each : explained(record_.answers, facts_))
      dialog_.say(fmt::format("{} = {}: {}", each.key, each.answer, each.why), 2);
    fmt::print("\n");
  }

  // Writes the configuration and the notes. Returns false after a message if the configuration would not be
  // valid.
  bool write() {
    const std::string text = this->text();
    if (options_.non_interactive) require_replaceable();
    if (!is_up_to_date()) {
      try {
        // A configuration that this run has written needs no copy.
        const bool own = own_text_ && bytes_of(file_) == *own_text_;
        const auto kept = replace_config(file_, text, own ? FileBefore::Gone : FileBefore::Kept);
        if (kept) dialog_.say(fmt::format("The previous configuration is kept as {}.", kept->string()));
      } catch (const ConfigError& error) {
        if (options_.non_interactive) throw;
        for (const Violation& violation : error.violations())
          dialog_.say(fmt::format("{}: {}: {}", violation.file, violation.pointer, violation.message), 2);
        dialog_.say("Nothing was written: the answers do not fit the rest of the file.");
        return false;
      }
      before_ = own_text_ = text;
      expect_restart(record_);
    }
    keep();
    write_durably(notes_file_, notes_of(record_.answers, facts_, file_.string()));
    dialog_.say(fmt::format("{}: good. The choices and their reasons are in {}.", file_.string(),
                            notes_file_.string()));
    return true;
  }
  // Throws UsageError if the write would replace an edited configuration without --replace.
  void require_replaceable() const {
    if (!before_ || options_.replace || is_up_to_date()) return;
    const fs::path shipped = fs::path(kShipped) / "contourd.json";
    if (std::error_code none; fs::exists(shipped, none) && *before_ == bytes_of(shipped)) return;
    throw UsageError(fmt::format(
        "setup: {} was edited after its installation: use --replace to replace it; a copy is kept",
        file_.string()));
  }

  int check() {
    if (record_.answers.at("hardware") != "real") {
      dialog_.say("Apply it with: sudo systemctl reload-or-restart contourd");
      return kOk;
    }
    check_printer({.client = client_,
                   .dialog = dialog_,
                   .record = record_,
                   .config = file_,
                   .keep = [this] { keep(); },
                   .write = [this] { return write(); }});
    return kOk;
  }

  const ClientOptions& client_;
  const SetupOptions& options_;
  fs::path file_, record_file_, notes_file_;
  std::optional<std::string> before_, own_text_;  // the configuration's text: on disk; written by this run
  Json base_;
  SetupFacts facts_;
  SetupRecord record_;
  SetupDialog dialog_;
};

}  // namespace

void add_setup(Command& program) {
  Command& command =
      program.add("setup", "Set up a wired printer, step by step, and write its configuration");
  auto& options = command.arguments<SetupOptions>();
  command.option("--config", options.config, "Configuration to write");
  command.option("--non-interactive", options.non_interactive,
                 "Ask nothing: use the given answers and safe suggestions");
  command.option("--set", options.set, "Give an answer as KEY=VALUE; repeatable").allow_empty();
  command.option("--answers", options.answers, "Read answers from this JSON file");
  command.option("--restart", options.restart, "Discard the answers of earlier runs");
  command.option("--replace", options.replace,
                 "Replace an edited configuration without asking (a copy is kept)");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &options] { return Setup(client, options).run(); };
}

}  // namespace contourd::ctl
