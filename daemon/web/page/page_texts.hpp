// The files of the page; the build generates the definitions.
#pragma once

#include <string_view>

namespace contourd {

extern const std::string_view page_html_text;
extern const std::string_view page_css_text;
extern const std::string_view page_base_text;
extern const std::string_view page_care_text;
extern const std::string_view page_change_text;
extern const std::string_view page_history_text;
extern const std::string_view page_job_text;
extern const std::string_view page_print_text;
extern const std::string_view page_queue_text;
extern const std::string_view page_service_text;
extern const std::string_view page_start_text;
extern const std::string_view page_upload_text;
extern const std::string_view page_icon_text;

}  // namespace contourd
