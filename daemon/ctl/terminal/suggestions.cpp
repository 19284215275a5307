#include "daemon/ctl/terminal/suggestions.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "daemon/client/control_defaults.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

// Returns the method's result, or an empty object if contourd does not answer or refuses.
Json result_of(const Request& request) {
  try {
    DaemonConnection connection(default_socket());
    return connection.ask(request).value("result", Json::object());
  } catch (const std::exception&) {
    return Json::object();
  }
}

// Returns the names of the jobs in the list `key` whose state is `state`; empty: any state.
std::vector<std::string> jobs_in(const Json& result, const char* key, const std::string& state = "") {
  std::vector<std::string> names;
  for (const Json& job : result.value(key, Json::array()))
    if (state.empty() || job.value("state", "") == state) names.push_back(printable(job.value("job", "")));
  return names;
}

}  // namespace

std::vector<std::string> waiting_jobs() {
  return jobs_in(result_of({"queue"}), "jobs");
}

std::vector<std::string> unaccepted_jobs() {
  return jobs_in(result_of({"queue"}), "jobs", "unaccepted");
}

std::vector<std::string> current_jobs() {
  std::vector<std::string> names = waiting_jobs();
  const Json status = result_of({"status"});
  if (const auto job = status.find("job"); job != status.end() && job->is_object())
    names.insert(names.begin(), printable(job->value("name", "")));
  return names;
}

std::vector<std::string> all_jobs() {
  constexpr int kLatest = 20;
  std::vector<std::string> names = current_jobs();
  std::ranges::move(jobs_in(result_of({"history", {{"last", kLatest}}}), "ended"), std::back_inserter(names));
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::vector<std::string> resins() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& file : std::filesystem::directory_iterator(
           std::filesystem::path(kDefaultConfig).parent_path() / "resins", ignored))
    if (file.path().extension() == ".json") names.push_back(printable(file.path().stem().string()));
  return names;
}

}  // namespace contourd::ctl
