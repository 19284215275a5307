#include "daemon/ctl/models/read_model.hpp"

#include "core/formats/model_reader.hpp"
#include "daemon/prepare/job_memory.hpp"

namespace contourd::ctl {
namespace {

void require_memory(const std::filesystem::path& path) {
  const FileToRead file{outline_of_model(path)};
  const MemoryRoom room = memory_room(std::nullopt);
  const std::uint64_t needed = memory_to_prepare({&file, 1}, DisplayGeometry{});
  if (needed > room.bytes) throw JobTooLarge({&file, 1}, "", needed, room);
}

}  // namespace

Model read_model(const std::filesystem::path& path) {
  try {
    require_memory(path);
    return read_model_file(path);
  } catch (const ModelError& error) {
    throw ModelError(path.string() + ": " + error.what());
  } catch (const JobTooLarge& error) {
    throw ModelError(path.string() + ": " + error.what());
  }
}

void look_at_model(const std::filesystem::path& path) {
  try {
    (void)outline_of_model(path);
  } catch (const ModelError& error) {
    throw ModelError(path.string() + ": " + error.what());
  }
}

PreparedJob prepare_model(const JobFiles& files, const PrinterConfig& printer, const AskedOfJob& asked) {
  try {
    JobSettings settings = read_settings(files, printer);
    if (asked.supports) settings.supports = *asked.supports;
    settings.resin.undersides = asked.undersides.value_or(settings.resin.undersides);
    settings.resin.mode = asked.mode.value_or(settings.resin.mode);
    if (asked.scale) {
      settings.ticket.models.front().scale = Scale{*asked.scale};
      settings.ticket.models.front().fit = false;
    }
    return prepare_job(files, settings, printer);
  } catch (const ProfileTrouble& trouble) {
    if (trouble.fault() == ProfileTrouble::Fault::Profile) throw;
    throw ModelError(files.model.string() + ": " + trouble.what());
  } catch (const JobRefused& refusal) {
    throw ModelError(files.model.string() + ": " + refusal.what());
  }
}

}  // namespace contourd::ctl
