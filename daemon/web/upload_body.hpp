// The bodies of requests that upload a model: the plain file that the page sends, and the form of slicers.
// Event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/web/http_request.hpp"
#include "daemon/web/model_upload.hpp"
#include "daemon/web/printer/control_link.hpp"

struct MHD_PostProcessor;

namespace contourd::web {

// The printer's side of uploads; all of it outlives them.
struct UploadPlaces {
  Worker& disk;
  ControlLink& printer;  // reports the spool's folder
  UploadLimits limits;
  int under_way = 0;
};

// Writes a model as it arrives, and replies with the job's name. After a refusal the rest of the body is
// discarded, so that the client reads the reply.
class UploadBody : public HttpBody {
 public:
  using Stored = std::function<void(const std::string& job)>;

  // `stored` is called when the model is in the spool.
  UploadBody(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, UploadedJob job,
             Stored stored);
  ~UploadBody() override;
  UploadBody(const UploadBody&) = delete;
  UploadBody& operator=(const UploadBody&) = delete;

  [[nodiscard]] bool take(std::string_view piece) override { return put(std::string(piece)); }
  void end() override;

 protected:
  // Writes bytes of the model. Returns false if the client has to wait for the disk.
  [[nodiscard]] bool put(std::string bytes);
  void refuse(UploadRefusal refusal);
  [[nodiscard]] bool is_refused() const { return refusal_.has_value(); }
  void set_name(std::string name);
  [[nodiscard]] const std::string& name() const { return job_.name; }
  [[nodiscard]] std::shared_ptr<HttpRequest> request() const { return request_.lock(); }

 private:
  // Calls `next` when the spool's folder is known.
  void open(std::function<void()> next);
  void write(std::string bytes);
  void finish();
  void reply();

  UploadPlaces& places_;
  std::weak_ptr<HttpRequest> request_;
  UploadedJob job_;
  Stored stored_;
  std::optional<ModelUpload> upload_;
  std::optional<UploadRefusal> refusal_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

// A form (multipart/form-data) whose part `file` is the model.
class UploadForm final : public UploadBody {
 public:
  static constexpr int kMostParts = 16;

  UploadForm(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, Stored stored);
  ~UploadForm() override;

  [[nodiscard]] bool take(std::string_view piece) override;
  void end() override;

 private:
  struct Callback;

  MHD_PostProcessor* parser_ = nullptr;
  std::string key_, bytes_;  // key of the form's part; bytes of the model since the last piece
  int parts_ = 0;
};

}  // namespace contourd::web
