// A client's connection to contourd: one JSON message a line (docs/control-api.md). Not thread-safe.
#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/client/daemon_error.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {

// A call of one of contourd's methods; the parameters by name.
struct Request {
  std::string method;
  nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
};

class DaemonConnection {
 public:
  using Json = nlohmann::ordered_json;
  using Time = std::chrono::steady_clock::time_point;

  // Throws DaemonError when it cannot be made, as the calls below do when it breaks. A daemon that is too
  // busy to take it, or what is sent, is given up after so long; without that it is waited for.
  explicit DaemonConnection(const std::filesystem::path& path,
                            std::optional<std::chrono::seconds> patience = std::nullopt);

  // The parameters by name.
  void send(const std::string& method, int id, const Json& parameters = Json::object());
  // Blocks.
  Json receive() { return *receive_until(Time::max()); }
  // Sends the request and returns the response, which has a "result" or an "error". Blocks.
  Json ask(const Request& request);
  // Readable while a message may be there.
  [[nodiscard]] int descriptor() const { return socket_.get(); }
  // Nothing when none comes until then.
  std::optional<Json> receive_until(Time time);

 private:
  // False when the time has come before.
  bool wait_until(Time time);

  std::string path_;
  FileDescriptor socket_;
  std::string received_;
};

}  // namespace contourd
