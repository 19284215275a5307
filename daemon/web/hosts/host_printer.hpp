// The printer, as the interfaces of other print hosts use it: a few of contourd's methods, each called for a
// request that is then answered. None of them moves the plate or switches the light by hand. Event loop's
// thread only.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"
#include "daemon/web/hosts/host_jobs.hpp"
#include "daemon/web/http_request.hpp"
#include "daemon/web/printer/control_link.hpp"
#include "daemon/web/printer/mask_picture.hpp"
#include "daemon/web/upload_body.hpp"
#include "daemon/web/web_config.hpp"

namespace contourd::web {

// The only methods that are called, with the one that stops what somebody moves or lights by hand.
inline constexpr std::array<std::string_view, 11> kHostMethods{"status", "queue",   "resins", "methods",
                                                               "mask",   "preview", "accept", "queue_remove",
                                                               "pause",  "resume",  "cancel"};
inline constexpr std::string_view kHostStop = "stop";

// The job that a client names, by its number or by its file.
struct HostJobKey {
  std::optional<std::uint32_t> id{};
  std::string file{};
};

class HostPrinter {
 public:
  using Json = ControlLink::Json;
  using RequestPtr = std::shared_ptr<HttpRequest>;
  using Done = std::function<void()>;

  HostPrinter(EventLoop& loop, const Log& log, const WebConfig& config);
  // All jobs, and the status.
  struct Found {
    std::vector<HostJob> jobs;
    Json status;
  };

  HostPrinter(const HostPrinter&) = delete;
  HostPrinter& operator=(const HostPrinter&) = delete;

  // Each answers the request with a sentence if contourd refuses, or cannot be asked; otherwise it calls the
  // function later.

  // Asks these questions, one after another, and passes the results on in their order.
  void ask(const RequestPtr& request, std::vector<Request> questions,
           std::function<void(const std::vector<Json>& results)> answered);
  void read_status(const RequestPtr& request, std::function<void(const HostStatus& status)> read);
  void list_jobs(const RequestPtr& request, std::function<void(const std::vector<HostJob>& jobs)> listed);
  // Finds the only job with this key.
  void find(const RequestPtr& request, const HostJobKey& key,
            std::function<void(const HostJob& job, const Found& among)> found);
  // Begins a waiting job now. Refuses it if the printer cannot print at once, prints another job first, or
  // asks about the job's findings, which the client does not show. Serves one start at a time, since a job
  // that is accepted while another one begins would be printed after it.
  void start(const RequestPtr& request, const HostJobKey& key, Done done);
  // Removes a waiting job.
  void remove(const RequestPtr& request, const HostJobKey& key,
              std::function<void(const HostJob& job)> removed);
  // Calls `pause`, `resume` or `cancel`.
  void control(const RequestPtr& request, std::string_view method, Done done);
  // Ends the print, or without one what is moved or lit by hand.
  void stop_all(const RequestPtr& request, Done done);

  // Answers with a picture of a waiting job, or with the present mask of the print under way.
  void show(const RequestPtr& request, const HostJobKey& key);
  void show_mask(const RequestPtr& request);

  [[nodiscard]] UploadPlaces& uploads() { return uploads_; }
  [[nodiscard]] HostStatusReader& reader() { return reader_; }
  [[nodiscard]] const std::filesystem::path& control_socket() const { return socket_; }
  // Logs that a client has uploaded a job.
  void note_upload(const HttpRequest& request, const std::string& job) const;

 private:
  struct Questions;
  // The job that was started last, which is neither in the queue nor under way for a moment.
  struct Leaving {
    std::string name, file;
    TimePoint until;
  };

  void ask_next(const std::shared_ptr<Questions>& questions);
  void call(const RequestPtr& request, Request question, Done done);
  [[nodiscard]] bool is_leaving() const;
  void note_begin(const Json& status);
  void log_command(const HttpRequest& request, std::string_view method) const;
  void show_preview(const RequestPtr& request, const HostJob& job);

  const Log& log_;
  std::filesystem::path socket_;
  ControlLink printer_, slow_;  // `slow_` is for methods that wait for a disk or a thread
  MaskPicture mask_;
  Worker disk_;
  UploadPlaces uploads_;
  HostStatusReader reader_;
  std::weak_ptr<const bool> start_;  // exists while a job is being started
  std::optional<Leaving> leaving_;
};

}  // namespace contourd::web
