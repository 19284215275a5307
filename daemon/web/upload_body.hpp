// The bodies of requests that upload a model: the plain file that the page sends, and the form of slicers.
// Event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/web/http_request.hpp"
#include "daemon/web/model_upload.hpp"
#include "daemon/web/printer/control_link.hpp"

struct MHD_PostProcessor;

namespace contourd::web {

// The printer's side of uploads; all of it outlives them.
struct UploadPlaces {
  // Uploads at the same time.
  static constexpr int kMostUploads = 4;
  // Bytes of a body besides the model.
  static constexpr std::size_t kMostBeside = 8192;

  Worker& disk;
  ControlLink& printer;  // reports the spool's folder
  UploadLimits limits;
  int under_way = 0;

  // Refuses an upload before its body is received. True if it has.
  [[nodiscard]] bool refuse(HttpRequest& request) const;
  // Returns the limit that ends a client which goes on after the refusal of its model's size.
  [[nodiscard]] std::uint64_t most_bytes() const { return 2 * (limits.most_bytes + kMostBeside); }
};

// Returns a ticket that has a job wait until a user accepts it.
inline constexpr std::string_view kConfirmTicket = "{\"confirm\": true}\n";

// Writes a model as it arrives. After a refusal the rest of the body is discarded, so that the client reads
// the reply.
class UploadBody : public HttpBody {
 public:
  // Returns the reply for a model that is in the spool.
  using Stored = std::function<HttpReply(const std::string& job)>;

  // The model's file has this name, unless it is empty, and the job has this ticket, unless it is empty.
  UploadBody(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, std::string name,
             std::string ticket, Stored stored);
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
  [[nodiscard]] const std::string& name() const { return name_; }
  // Calls `next`, now or later, when the ticket of a complete model is known, or was refused.
  virtual void settle_ticket(std::function<void()> next) { next(); }
  void set_ticket(std::string ticket) { ticket_ = std::move(ticket); }
  // Returns a guard that has expired when the body is gone.
  [[nodiscard]] std::weak_ptr<const bool> guard() const { return alive_; }
  [[nodiscard]] std::shared_ptr<HttpRequest> request() const { return request_.lock(); }

 private:
  // Calls `next` when the spool's folder is known.
  void open(std::function<void()> next);
  void write(std::string bytes);
  void finish();
  void reply();

  UploadPlaces& places_;
  std::weak_ptr<HttpRequest> request_;
  std::string name_, ticket_;
  Stored stored_;
  std::optional<ModelUpload> upload_;
  std::optional<UploadRefusal> refusal_;
  std::shared_ptr<const bool> alive_ = std::make_shared<const bool>(true);
};

// A form (multipart/form-data), of which a part is the model.
class UploadForm : public UploadBody {
 public:
  static constexpr int kMostParts = 16;

  // `part` is the key of the model's part, which has its file's name.
  UploadForm(UploadPlaces& places, const std::shared_ptr<HttpRequest>& request, const char* part,
             std::string ticket, Stored stored);
  ~UploadForm() override;

  [[nodiscard]] bool take(std::string_view piece) override;
  void end() override;

 protected:
  // Returns the model's name; nullopt if the part is no file. `file` is the part's own name, or null.
  [[nodiscard]] virtual std::optional<std::string> name_of(const char* file) const;
  // Takes a piece of another part; `begins` with the part's first piece.
  virtual void take_field(std::string_view /*key*/, std::string_view /*piece*/, bool /*begins*/) {}

 private:
  struct Callback;

  MHD_PostProcessor* parser_ = nullptr;
  const char* part_;
  std::string bytes_;  // bytes of the model since the last piece
  int parts_ = 0;
};

}  // namespace contourd::web
