#include "daemon/web/page/page_files.hpp"

#include <algorithm>
#include <array>

#include "daemon/web/page/page_texts.hpp"

namespace contourd::web {
namespace {

constexpr const char* kScript = "text/javascript; charset=utf-8";

const std::array kFiles{PageFile{"/", "text/html; charset=utf-8", page_html_text},
                        PageFile{"/page.css", "text/css; charset=utf-8", page_css_text},
                        PageFile{"/base.js", kScript, page_base_text},
                        PageFile{"/care.js", kScript, page_care_text},
                        PageFile{"/change.js", kScript, page_change_text},
                        PageFile{"/history.js", kScript, page_history_text},
                        PageFile{"/job.js", kScript, page_job_text},
                        PageFile{"/print.js", kScript, page_print_text},
                        PageFile{"/queue.js", kScript, page_queue_text},
                        PageFile{"/service.js", kScript, page_service_text},
                        PageFile{"/start.js", kScript, page_start_text},
                        PageFile{"/upload.js", kScript, page_upload_text},
                        PageFile{"/icon.svg", "image/svg+xml", page_icon_text}};

}  // namespace

const PageFile* page_file(std::string_view path) {
  const auto* const file = std::ranges::find(kFiles, path, &PageFile::path);
  return file == kFiles.end() ? nullptr : file;
}

}  // namespace contourd::web
