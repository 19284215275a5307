// The form by which NanoDLP's clients add a plate: Path, a name; ProfileID, the resin's number; and ZipFile.
// Event loop's thread only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/web/hosts/host_printer.hpp"
#include "daemon/web/upload_body.hpp"

namespace contourd::web {

// Stores a plate as a job that waits until it is started. The job's name is Path, which is a file's name and
// never a path.
class NanodlpUpload final : public UploadForm {
 public:
  static constexpr std::size_t kLongestField = 256;

  // The printer must outlive the object.
  NanodlpUpload(HostPrinter& printer, const std::shared_ptr<HttpRequest>& request);

 private:
  [[nodiscard]] std::optional<std::string> name_of(const char* file) const override;
  void take_field(std::string_view key, std::string_view piece, bool begins) override;
  void settle_ticket(std::function<void()> next) override;

  HostPrinter& printer_;
  std::string path_, profile_;
};

}  // namespace contourd::web
