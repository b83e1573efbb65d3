// Messages of one SQLite file of a ROS 2 bag (rosbag2_storage_sqlite3): tables "topics" and "messages".
#pragma once

#include <filesystem>
#include <memory>

#include "base/error.h"
#include "protocol/import/files/message_source.h"

namespace fire3dv::imported {

// True for a file that begins as SQLite's do.
bool is_sqlite_file(const std::filesystem::path& path);

Result<std::unique_ptr<MessageSource>> open_sqlite_messages(const std::filesystem::path& path,
                                                            const ShouldStop& should_stop);

}  // namespace fire3dv::imported
