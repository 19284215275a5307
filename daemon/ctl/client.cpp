#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "daemon/readable.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd::ctl {
namespace {

using Json = nlohmann::ordered_json;

// One connection to contourd. Throws DaemonError when it cannot be made or breaks.
class Connection {
 public:
  explicit Connection(const std::filesystem::path& path)
      : path_(path.string()), socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path_.size() >= sizeof address.sun_path)
      throw DaemonError(fmt::format("{}: the path is too long", path_));
    std::memcpy(address.sun_path, path_.c_str(), path_.size() + 1);
    if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw DaemonError(fmt::format("cannot reach contourd on {}: {}", path_, std::strerror(errno)));
    }
  }

  void send(const std::string& method, int id) {
    const std::string line = Json{{"jsonrpc", "2.0"}, {"method", method}, {"id", id}}.dump() + "\n";
    if (::send(socket_.get(), line.data(), line.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(line.size())) {
      throw DaemonError(fmt::format("contourd on {} closed the connection", path_));
    }
  }

  Json receive() {
    std::size_t end = 0;
    while ((end = received_.find('\n')) == std::string::npos) {
      std::array<char, 65536> buffer;
      const ssize_t bytes = ::read(socket_.get(), buffer.data(), buffer.size());
      if (bytes < 0 && errno == EINTR) continue;
      if (bytes <= 0) throw DaemonError(fmt::format("contourd on {} closed the connection", path_));
      received_.append(buffer.data(), static_cast<std::size_t>(bytes));
    }
    const std::string line = received_.substr(0, end);
    received_.erase(0, end + 1);
    return Json::parse(line);
  }

 private:
  std::string path_;
  FileDescriptor socket_;
  std::string received_;
};

std::string left(const Json& job) {
  const std::chrono::duration<double> seconds(job.value("time_left_s", 0.0));
  return readable(std::chrono::duration_cast<Duration>(seconds));
}

void print_analysis(const Json& analysis) {
  fmt::print("resin     {:.2f} ml\n", analysis.value("resin_ml", 0.0));
  for (const Json& warning : analysis["warnings"])
    fmt::print("warning   {}\n", printable(warning.get<std::string>()));
}

void print_status(const Json& status) {
  fmt::print("printer   {}\nstate     {}\n", printable(status.value("printer", "")),
             printable(status.value("state", "")));
  if (status["job"].is_object()) {
    const Json& job = status["job"];
    fmt::print("job       {}\n", printable(job.value("name", "")));
    if (job.contains("layer")) {
      fmt::print("layer     {} of {}, {:.3f} mm, {} left{}\n", job.value("layer", 0), job.value("layers", 0),
                 job.value("height_mm", 0.0), left(job),
                 job.value("pause_pending", false) ? ", pause after this layer" : "");
      if (job["interruption"].is_string())
        fmt::print("stopped   {}\n", printable(job["interruption"].get<std::string>()));
    }
    if (job.contains("analysis") && job["analysis"].is_object()) print_analysis(job["analysis"]);
  }
  fmt::print(
      "plate     {}{}\n", printable(status.value("plate", "")),
      status["plate_job"].is_string() ? " by " + printable(status["plate_job"].get<std::string>()) : "");
  fmt::print("queue     {}\n", status.value("queued", 0));
  for (const auto& [file, why] : status["postponed"].items())
    fmt::print("postponed {}: {}\n", printable(file), why.get<std::string>());
  for (const Json& file : status["deletable"])
    fmt::print("deletable {} in incoming: it had its turn, and cannot be moved\n",
               printable(file.get<std::string>()));
  for (const auto& [file, why] : status["passed_over"].items())
    fmt::print("unprinted {} in incoming: {}\n", printable(file), printable(why.get<std::string>()));
  if (const auto more = status.value("passed_over_more", std::size_t{0}); more > 0)
    fmt::print("unprinted {} more in incoming\n", more);
  if (status["hindrance"].is_string())
    fmt::print("machine   {}\n", printable(status["hindrance"].get<std::string>()));
  if (status["held"].is_string()) fmt::print("held      {}\n", printable(status["held"].get<std::string>()));
  if (status["waiting_for"].is_string() && status["waiting_for"] != status["held"])
    fmt::print("waiting   {}\n", printable(status["waiting_for"].get<std::string>()));
  if (status["last"].is_object()) {
    const Json& last = status["last"];
    const std::string reason = last.value("reason", "");
    fmt::print("last job  {}: {}{}\n", printable(last.value("job", "")), printable(last.value("outcome", "")),
               reason.empty() ? "" : ": " + printable_lines(reason));
  }
}

void print_queue(const Json& result) {
  const Json& queue = result["queue"];
  if (queue.empty()) fmt::print("the queue is empty\n");
  for (std::size_t i = 0; i < queue.size(); ++i)
    fmt::print("{:>3}  {}\n", i + 1, printable(queue[i].get<std::string>()));
  if (const auto more = result.value("more", std::size_t{0}); more > 0) fmt::print("and {} more\n", more);
}

// The bar on a terminal; elsewhere a line for every tenth of the print.
class ProgressView {
 public:
  void show(const Json& status) {
    if (!status["job"].is_object()) return;
    const Json& job = status["job"];
    const std::string name = printable(job.value("name", "")), state = status.value("state", "");
    if (!job.contains("layer")) return line(fmt::format("{}: {}", name, state), state);
    const double layers = std::fmax(job.value("layers", 1), 1);
    const double part = job.value("layers_done", 0) / layers;
    constexpr int kBar = 30;
    std::string bar(kBar, '.');
    std::fill_n(bar.begin(), static_cast<int>(part * kBar), '#');
    const std::string text = fmt::format(
        "{} [{}] {:3.0f} %  layer {}/{}  {:.2f} mm  {} left  {}", name, bar, std::floor(part * 100),
        job.value("layer", 0), job.value("layers", 0), job.value("height_mm", 0.0), left(job),
        job["interruption"].is_string() ? state + ", " + printable(job["interruption"].get<std::string>())
                                        : state);
    line(text, std::to_string(static_cast<int>(part * 10)));
  }

  void end() {
    if (terminal_ && shown_) fmt::print("\n");
  }

 private:
  void line(const std::string& text, const std::string& step) {
    if (terminal_) {
      fmt::print("\r\x1B[K{}", text);
    } else if (step != last_step_) {
      fmt::print("{}\n", text);
    }
    std::fflush(stdout);
    last_step_ = step;
    shown_ = true;
  }

  bool terminal_ = ::isatty(STDOUT_FILENO) != 0;
  bool shown_ = false;
  std::string last_step_;
};

int print_end(const Json& ended, bool json) {
  const std::string outcome = ended.value("outcome", ""), reason = ended.value("reason", "");
  if (!json) {
    fmt::print("{}: {}{}\n", printable(ended.value("job", "")), outcome,
               reason.empty() ? "" : ": " + printable_lines(reason));
  }
  return outcome == "done" ? kOk : kFailed;
}

// The end of the job of that name that came last, if it is known.
std::optional<Json> end_of(const Json& history, const std::string& job) {
  const Json& ended = history["ended"];
  for (auto each = ended.rbegin(); each != ended.rend(); ++each) {
    if (each->value("job", "") == job) return *each;
  }
  return std::nullopt;
}

}  // namespace

int request(const ClientOptions& options, const std::string& method) {
  Connection connection(options.socket);
  connection.send(method, 1);
  const Json answer = connection.receive();
  if (options.json) fmt::print("{}\n", answer.dump(-1, ' ', true));
  if (answer.contains("error")) {
    if (!options.json)
      fmt::print(stderr, "contourctl: {}\n", printable_lines(answer["error"].value("message", "")));
    return kFailed;
  }
  if (options.json) return kOk;
  if (method == "queue") {
    print_queue(answer["result"]);
  } else {
    print_status(answer["result"]);
  }
  return kOk;
}

int watch(const ClientOptions& options, const std::optional<std::string>& wanted_job) {
  Connection connection(options.socket);
  constexpr int kStatus = 2, kHistory = 3;
  connection.send("watch", 1);
  connection.send("status", kStatus);
  connection.send("history", kHistory);
  ProgressView view;
  std::string under_way = wanted_job.value_or("");
  while (true) {
    const Json message = connection.receive();
    if (options.json) {
      fmt::print("{}\n", message.dump(-1, ' ', true));
      std::fflush(stdout);
    }
    if (wanted_job && message.value("id", 0) == kHistory) {
      if (const auto end = end_of(message["result"], *wanted_job)) return print_end(*end, options.json);
    }
    const bool first = message.value("id", 0) == kStatus;
    if (!first && !message.contains("params")) continue;
    const Json& status = first ? message["result"] : message["params"];
    const bool any_ended = message.value("method", "") == "ended";
    if (!wanted_job && !any_ended && status["job"].is_object()) under_way = status["job"].value("name", "");
    if (!options.json) view.show(status);
    // A refusal in the queue is not the end of the print that is being watched.
    if (!any_ended || (!under_way.empty() && status["last"].value("job", "") != under_way)) continue;
    if (!options.json) view.end();
    return print_end(status["last"], options.json);
  }
}

}  // namespace contourd::ctl
