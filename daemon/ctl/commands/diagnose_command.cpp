#include "daemon/ctl/commands/commands.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "daemon/client/control_defaults.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/commands/machine_facts.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/program.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {
namespace {

struct DiagnoseOptions {
  std::optional<std::filesystem::path> output;  // nullopt: named by the time, in the working folder
  std::filesystem::path config = kDefaultConfig;
  std::optional<std::string> job;  // nullopt: the latest
};

namespace fs = std::filesystem;
using Json = DaemonConnection::Json;
using namespace std::chrono_literals;

constexpr const char* kFolder = "contourd-diagnosis";
// Limit for one file: room for about 2000 lines of the journal.
constexpr std::size_t kMostBytes = 1'000'000;
constexpr std::size_t kMostArchived = 20'000'000;
constexpr std::size_t kMostProfiles = 50;
constexpr auto kLongestAnswer = 5s;

// --- private words

constexpr std::string_view kStruck = "***";
constexpr std::array<std::string_view, 8> kSecrets{"password", "passwd",     "passphrase", "token",
                                                   "secret",   "credential", "macaddr",    "key"};

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// Returns the text with ASCII capitals as small letters.
std::string in_small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return small;
}

// Returns the position of a secret's value: after its name, which may continue with other letters and quotes,
// and after ':' or '='. npos if there is none.
std::size_t secret_in(const std::string& line) {
  const std::string small = in_small_letters(line);
  std::size_t first = std::string::npos;
  for (const std::string_view word : kSecrets) {
    for (std::size_t at = small.find(word); at != std::string::npos; at = small.find(word, at + 1)) {
      std::size_t end = at + word.size();
      while (end < small.size() && (is_letter(small[end]) || is_digit(small[end]) ||
                                    std::string_view("_-\"' ").find(small[end]) != std::string_view::npos))
        ++end;
      if (end < small.size() && (small[end] == ':' || small[end] == '=')) first = std::min(first, end + 1);
    }
  }
  return first;
}

void strike_homes(std::string& line) {
  constexpr std::string_view kHome = "/home/";
  for (std::size_t at = line.find(kHome); at != std::string::npos; at = line.find(kHome, at + 1)) {
    const std::size_t name = at + kHome.size();
    const std::size_t end = std::min(line.find_first_of("/\"', \t:;)", name), line.size());
    line.replace(name, end - name, kStruck);
  }
}

void strike_users(std::string& line) {
  constexpr std::string_view kUser = "user ";
  for (std::size_t at = line.find(kUser); at != std::string::npos; at = line.find(kUser, at + 1)) {
    const std::size_t name = at + kUser.size();
    const std::size_t space = line.find(' ', name);
    if (space == std::string::npos || space + 2 >= line.size() || line[space + 1] != '(') continue;
    if (!is_digit(line[space + 2])) continue;
    const std::size_t end = std::min(line.find(')', space), line.size() - 1);
    line.replace(name, end + 1 - name, kStruck);
  }
}

// Returns the text with *** in place of each value after a word such as password, token, secret or key and
// ':' or '=' in its line, and of the names of users after /home/ and in "user NAME (NUMBER)".
std::string without_private_words(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (const std::size_t secret = secret_in(line); secret != std::string::npos)
      line.replace(secret, std::string::npos, std::string(" ").append(kStruck));
    strike_homes(line);
    strike_users(line);
    clean.append(line).append("\n");
  }
  return clean;
}

// --- the files

// The files of the archive by name, with private words removed.
class Diagnosis {
 public:
  void add(const std::string& name, std::string_view text) {
    std::string clean = without_private_words(text.substr(0, kMostBytes));
    if (text.size() >= kMostBytes) clean += "(the rest is left out)\n";
    files_[name] = std::move(clean);
  }
  // Adds a file's text, or the reason why the file cannot be read.
  void add_file(const std::string& name, const fs::path& file, Links links) {
    try {
      add(name, beginning_of(file, kMostBytes, links));
    } catch (const UnreadableFile& error) {
      add(name, fmt::format("({}: {})\n", file.string(), error.what()));
    }
  }
  [[nodiscard]] const std::map<std::string, std::string>& files() const { return files_; }

 private:
  std::map<std::string, std::string> files_;
};

// A temporary folder that only this user can read; the destructor removes it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "contourctl-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::system_error(errno, std::generic_category(), "cannot make " + name);
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// Adds contourd's answers. Returns its status, or null if contourd does not answer.
Json ask_daemon(const ClientOptions& client, Diagnosis& diagnosis) {
  Json status;
  try {
    DaemonConnection connection(client.socket);
    const auto end = std::chrono::steady_clock::now() + kLongestAnswer;
    for (const char* method : {"status", "queue", "history"}) {
      connection.send(method, 1);
      const std::optional<Json> answer = connection.receive_until(end);
      if (!answer) throw DaemonError(fmt::format("contourd on {} does not answer", client.socket.string()));
      const Json result = answer->value("result", Json());
      diagnosis.add(fmt::format("{}.json", method), result.dump(1, ' ', true) + "\n");
      if (status.is_null()) status = result;
    }
  } catch (const std::exception& error) {
    diagnosis.add("status.json", fmt::format("({})\n", error.what()));
  }
  return status;
}

void add_profiles(const fs::path& folder, const char* name, Diagnosis& diagnosis) {
  std::size_t profiles = 0;
  try {
    for (const std::string& profile : profiles_in(folder))
      if (++profiles <= kMostProfiles)
        diagnosis.add_file(fmt::format("configuration/{}/{}.json", name, printable(profile)),
                           folder / (profile + ".json"), Links::Follow);
  } catch (const std::system_error& error) {
    diagnosis.add(fmt::format("configuration/{}.txt", name), fmt::format("({})\n", error.what()));
  }
}

// Adds the configuration files and contourd's findings about them. Returns the spool's folder, or an empty
// path if the configuration cannot be loaded.
fs::path add_configuration(const fs::path& file, Diagnosis& diagnosis) {
  diagnosis.add_file("configuration/contourd.json", file, Links::Follow);
  fs::path spool, resins = folder_of(file) / "resins";
  std::string findings;
  try {
    const PrinterConfig config = load_printer_config(file);
    for (const Violation& warning : config.warnings)
      findings += warning_line(warning) + "\n";
    findings += "good\n";
    spool = config.spool_folder;
    resins = config.resins_folder;
  } catch (const std::exception& error) {
    findings += fmt::format("{}\n", error.what());
  }
  diagnosis.add("configuration/check.txt", findings);
  add_profiles(resins, "resins", diagnosis);
  add_profiles(folder_of(file) / "projectors", "projectors", diagnosis);
  return spool;
}

void add_journal(const std::string& name, const std::vector<std::string>& matches, Diagnosis& diagnosis) {
  std::vector<std::string> words{"journalctl", "--unit=contourd.service", "--lines=2000",
                                 "--no-pager", "--no-hostname",           "--quiet",
                                 "--utc",      "--output=short-iso"};
  words.insert(words.end(), matches.begin(), matches.end());
  try {
    const std::string text = run_program(words, kMostBytes).text;
    diagnosis.add(name, text.empty() ? "(the journal has no matching lines that you may read)\n" : text);
  } catch (const std::system_error& error) {
    diagnosis.add(name, fmt::format("({})\n", error.what()));
  }
}

// Adds the job's lines in the journal, and its report or the reason of its failure.
void add_job(const std::string& job, const fs::path& spool, Diagnosis& diagnosis) {
  add_journal("job/journal.txt", {"JOB_ID=" + printable(job)}, diagnosis);
  if (spool.empty() || job.find('/') != std::string::npos) return;
  for (const char* folder : {"done", "failed"}) {
    for (const char* suffix : {"report.json", "reason.txt"}) {
      const fs::path file = spool / folder / fmt::format("{}.{}", job, suffix);
      std::error_code none;
      if (fs::exists(fs::symlink_status(file, none)))
        // Other users can write to these folders: no link is followed.
        diagnosis.add_file(fmt::format("job/{}.{}", folder, suffix), file, Links::Refuse);
    }
  }
}

std::string archive(const Diagnosis& diagnosis) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : diagnosis.files()) {
    const fs::path path = folder.path() / kFolder / name;
    fs::create_directories(path.parent_path());
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw OutputError(fmt::format("cannot write {}", path.string()));
  }
  const ProgramOutput packed =
      run_program({"tar", "--create", "--gzip", "--directory", folder.path().string(), "--owner=root:0",
                   "--group=root:0", "--sort=name", kFolder},
                  kMostArchived);
  if (packed.code != 0) throw OutputError(fmt::format("tar failed with {}", packed.code));
  return packed.text;
}

std::string list_of(const Diagnosis& diagnosis) {
  std::string list;
  for (const auto& [name, text] : diagnosis.files())
    list += fmt::format("{:>8}  {}\n", text.size(), name);
  return list;
}

[[noreturn]] void refuse(const fs::path& output) {
  throw OutputError(fmt::format("{} exists already and is not overwritten", output.string()));
}

void write_new(const fs::path& output, std::string_view bytes) {
  // Only this user can read the archive, and decides who else may.
  (void)::umask(S_IRWXG | S_IRWXO);
  try {
    NewFile file(folder_of(output));
    file.write(bytes);
    if (!file.appear(output.filename().string())) refuse(output);
  } catch (const std::system_error& error) {
    throw OutputError(fmt::format("cannot write {}: {}", output.string(), error.code().message()));
  }
}

fs::path output_of(const DiagnoseOptions& options) {
  if (options.output) return *options.output;
  return fmt::format("{}-{:%Y%m%d-%H%M%S}.tar.gz", kFolder, fmt::localtime(std::time(nullptr)));
}

int diagnose(const ClientOptions& client, const DiagnoseOptions& options) {
  const fs::path output = output_of(options);
  // Checked early, before the slow part; write_new() checks again.
  if (std::error_code none; fs::exists(fs::symlink_status(output, none))) refuse(output);
  Diagnosis diagnosis;
  const Json status = ask_daemon(client, diagnosis);
  fs::path spool = add_configuration(options.config, diagnosis);
  if (status.is_object() && !status.value("spool", "").empty()) spool = status.value("spool", "");
  std::optional<std::string> job = options.job;
  if (!job && status.is_object() && status["last"].is_object()) job = status["last"].value("job", "");
  add_journal("journal.txt", {}, diagnosis);
  if (job) add_job(*job, spool, diagnosis);
  diagnosis.add("versions.txt", versions());
  diagnosis.add("kernel.txt", kernel_facts());
  diagnosis.add("displays.txt", display_facts());
  diagnosis.add("gpio.txt", gpio_facts());
  diagnosis.add("serial.txt", serial_facts());
  const std::string list = list_of(diagnosis);
  diagnosis.add(
      "README.txt",
      fmt::format("Made by contourctl diagnose. Passwords, keys and the like, and users' names, are replaced "
                  "by ***. Names of jobs are not.\n\n{}",
                  list));
  write_new(output, archive(diagnosis));
  fmt::print(
      "{}{} contains these files, and only you can read it: check it before you share it, because it "
      "contains "
      "the names of jobs\n",
      list, printable(output.string()));
  return kOk;
}

}  // namespace

void add_diagnose(Command& program) {
  Command& command = program.add("diagnose", "Collect information for a bug report in one archive");
  auto& options = command.arguments<DiagnoseOptions>();
  command.option("JOB", options.job, "Include the report and journal of this job (default: the latest)")
      .suggests(all_jobs);
  command.option("-o,--output", options.output, "Archive to create (.tar.gz); the file must not exist yet");
  command.option("--config", options.config, "Configuration of the printer");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &options] { return diagnose(client, options); };
}

}  // namespace contourd::ctl
