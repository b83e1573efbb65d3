#include "programs/drake/render/request_pipeline.h"

#include <malloc.h>

#include <atomic>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>

#include "base/log.h"
#include "programs/drake/request/form.h"
#include "programs/drake/request/gltf_scene.h"

namespace fire3dv::drake {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint64_t kLargeBytes = 8 << 20;  // of a request; reading it takes some tenths of a second
// Loading leaves the processors to drawing.
constexpr int kLoadingNice = 10;
// Blocks of this size go back to the system when they are freed.
constexpr int kMappedBytes = 256 << 10;

const char* name_of(ImageType type) {
  return type == ImageType::color ? "color" : type == ImageType::depth ? "depth" : "label";
}

}  // namespace

struct RequestPipeline::Job {
  HttpRequest request;
  HttpServer::Answer answer;
  Clock::time_point begin = Clock::now();
  std::string client;
  uint64_t bytes = 0;
  RenderRequest form;
  std::optional<GltfScene> gltf;
  std::unique_ptr<LoadedDrakeScene> loaded;
  bool was_cached = true, is_answered = false;
  std::optional<sinks::FrameImage> image;

  void reply(HttpAnswer&& with) {
    if (is_answered) return;
    is_answered = true;
    answer(std::move(with));
    answer = nullptr;
  }
  bool is_color() const { return form.type == ImageType::color; }
};

RequestPipeline::RequestPipeline(ImageRenderer& renderer, std::function<void(const std::string&)> on_failure)
    : renderer_(renderer),
      on_failure_(std::move(on_failure)),
      drawing_({.threads = 1}),
      loading_({.threads = 2, .large_cost = kLargeBytes, .nice = kLoadingNice}),
      reading_({.threads = 3, .large_cost = kLargeBytes}) {
  (void)::mallopt(M_MMAP_THRESHOLD, kMappedBytes);
}

RequestPipeline::~RequestPipeline() {
  (void)stop(std::chrono::hours(1));
}

bool RequestPipeline::stop(std::chrono::milliseconds patience) {
  const Clock::time_point end = Clock::now() + patience;
  bool ended = true;
  for (WorkerPool* const pool : {&reading_, &loading_, &drawing_})
    ended = pool->stop(std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now())) && ended;
  return ended;
}

void RequestPipeline::push(HttpRequest&& request, HttpServer::Answer answer) {
  const auto job = std::make_shared<Job>();
  job->client = request.client;
  job->bytes = request.body.size();
  job->request = std::move(request);
  job->answer = std::move(answer);
  reading_.push(job->client, job->bytes, [this, job] { run(job, [&] { return read(job); }); });
}

void RequestPipeline::run(const JobPtr& job, const std::function<Result<void>()>& stage) {
  try {
    if (Result<void> done = stage(); !done) job->reply(http_error(400, done.error().message));
  } catch (const std::bad_alloc&) {
    job->reply(http_error(500, "there is no memory for this image"));
  } catch (const std::exception& failure) {
    job->reply(http_error(500, failure.what()));
  }
  if (job->is_answered && job->bytes > kLargeBytes) return_memory();
}

Result<void> RequestPipeline::read(const JobPtr& job) {
  Result<RenderRequest> form = read_form(job->request.body, job->request.content_type);
  if (!form) return form.error();
  if (auto good = ImageRenderer::check_camera(*form); !good) return good;
  Result<GltfScene> gltf = GltfScene::read(form->scene, form->type);
  if (!gltf) return gltf.error();
  job->form = *form;
  job->form.scene = {};
  job->gltf = std::move(*gltf);
  job->request = {};
  begin_draw(job);
  return {};
}

void RequestPipeline::begin_draw(const JobPtr& job) {
  drawing_.push(job->client, uint64_t{job->form.width} * job->form.height, [this, job] {
    if (has_failed_) return job->reply(http_error(500, "the device is lost"));
    try {
      run(job, [&]() -> Result<void> {
        try {
          return draw(job);
        } catch (const std::bad_alloc&) {
          throw;
        } catch (const std::exception& failure) {  // of Vulkan: the device is lost
          has_failed_ = true;
          on_failure_(failure.what());
          throw;
        }
      });
    } catch (const std::exception&) {  // run() has no memory for the answer
    }
  });
}

// On the drawing thread.
Result<void> RequestPipeline::draw(const JobPtr& job) {
  if (!renderer_.has(*job->gltf, job->is_color())) {
    if (!job->loaded) {
      const SceneKey key{job->is_color(), job->gltf->content()};
      const auto [entry, is_new] = waiting_.try_emplace(key);
      if (!is_new) return entry->second.push_back(job), Result<void>();
      job->was_cached = false;
      loading_.push(job->client, job->bytes, [this, job] {
        run(job, [&] { return load(job); });
        drawing_.push(job->client, 0, [this, job] { end_load(job); });
      });
      return {};
    }
    auto added = renderer_.add(*job->gltf, job->is_color(), std::move(job->loaded));
    return_memory();
    if (!added) return added;
  }
  job->loaded = nullptr;
  Result<sinks::FrameImage> image = renderer_.draw(job->form, *job->gltf);
  if (!image) return image.error();
  job->image = std::move(*image);
  job->gltf.reset();
  reading_.push(job->client, job->image->rgba8.size(),
                [this, job] { run(job, [&] { return encode(job); }); });
  return {};
}

Result<void> RequestPipeline::load(const JobPtr& job) {
  auto loaded = renderer_.load(*job->gltf, job->is_color());
  if (!loaded) return loaded.error();
  job->loaded = std::move(*loaded);
  return {};
}

// On the drawing thread: the request that has loaded its scene goes on, and those that wait for it.
void RequestPipeline::end_load(const JobPtr& job) {
  const auto entry = waiting_.find({job->is_color(), job->gltf->content()});
  std::vector<JobPtr> waiting = std::move(entry->second);
  waiting_.erase(entry);
  if (!job->is_answered) begin_draw(job);
  for (const JobPtr& each : waiting) begin_draw(each);
  if (job->is_answered) return_memory();
}

Result<void> RequestPipeline::encode(const JobPtr& job) {
  Result<RenderedImage> image = renderer_.encode(std::move(*job->image), job->form);
  if (!image) return image.error();
  if (!job->was_cached) {
    char text[160];
    std::snprintf(text, sizeof text, "%s image of a new scene of %.1f MiB in %.0f ms",
                  name_of(job->form.type), static_cast<double>(job->bytes) / (1 << 20),
                  std::chrono::duration<double, std::milli>(Clock::now() - job->begin).count());
    print_log_line("fire3dv-drake", text);
  }
  job->reply({200, std::move(image->content_type), std::move(image->file)});
  return {};
}

// The heap keeps what small blocks of a scene have used.
void RequestPipeline::return_memory() {
  loading_.push("", 0, [] { (void)::malloc_trim(0); });
}

}  // namespace fire3dv::drake
