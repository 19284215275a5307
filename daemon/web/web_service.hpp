// The web page of the printer: its requests, each checked and either answered or passed on to contourd. Event
// loop's thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"
#include "daemon/web/http_server.hpp"
#include "daemon/web/page/page_methods.hpp"
#include "daemon/web/printer/control_link.hpp"
#include "daemon/web/printer/fetched_file.hpp"
#include "daemon/web/printer/mask_picture.hpp"
#include "daemon/web/status_feed.hpp"
#include "daemon/web/upload_body.hpp"
#include "daemon/web/web_config.hpp"
#include "daemon/web/web_login.hpp"

namespace contourd::web {

class WebService {
 public:
  // Reports, pictures and films that are read or sent at the same time, each of up to 8 MiB.
  static constexpr int kMostFiles = 4;
  // Bytes of a body that is not a model.
  static constexpr std::size_t kMostBodyBytes = 8192;

  // Serves the clients of these listening sockets, which name this computer by one of `names`. Throws
  // std::runtime_error.
  WebService(EventLoop& loop, const Log& log, const WebConfig& config, WebSecrets secrets,
             std::vector<std::string> names, std::vector<FileDescriptor> listeners);

 private:
  using RequestPtr = std::shared_ptr<HttpRequest>;
  using Received = std::function<void(const RequestPtr& request, const std::string& body)>;

  void serve(const RequestPtr& request);
  // Answers with the reason if the request comes from a page of another site, or asks for another computer.
  [[nodiscard]] bool refuse_stranger(HttpRequest& request) const;
  void serve_anyone(const RequestPtr& request);
  // Returns the role of a request with a session or the key; otherwise answers it.
  [[nodiscard]] std::optional<Role> access_of(HttpRequest& request) const;
  void serve_user(const RequestPtr& request, Role role);
  void serve_slicer(const RequestPtr& request);
  void serve_events(const RequestPtr& request);
  void serve_query(const RequestPtr& request, Role role);
  void serve_preview(const RequestPtr& request);
  void serve_report(const RequestPtr& request);
  void serve_picture(const RequestPtr& request);
  void serve_film(const RequestPtr& request);
  // Answers with a file of contourd, of which `reply` says the rest.
  void serve_file(const RequestPtr& request, FileQuestion question, HttpReply reply);
  void pass_on(const RequestPtr& request, const PageMethod& method, const std::string& parameters);
  void ask(ControlLink& link, const RequestPtr& request, Request question);
  void serve_mask(const RequestPtr& request);
  void serve_history(const RequestPtr& request);
  void upload(const RequestPtr& request);
  [[nodiscard]] UploadBody::Stored note_upload(const RequestPtr& request) const;
  void receive(const RequestPtr& request, Received received);
  void log_login(const std::string& peer, std::optional<Role> role) const;

  const Log& log_;
  std::vector<std::string> names_;
  WebLogin login_;
  ControlLink printer_, slow_;  // `slow_` is for methods that wait for a disk
  MaskPicture mask_;
  StatusFeed feed_;
  std::shared_ptr<const int> file_place_ = std::make_shared<const int>(0);  // a reference for each file
  Worker disk_;
  UploadPlaces uploads_;
  HttpServer server_;  // last: its requests refer to the others
};

}  // namespace contourd::web
