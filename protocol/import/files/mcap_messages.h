// Messages of one MCAP file.
#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "protocol/import/files/message_source.h"

namespace fire3dv::imported {

Result<std::unique_ptr<MessageSource>> open_mcap_messages(const std::string& path,
                                                          const ShouldStop& should_stop);

}  // namespace fire3dv::imported
