/*
  Runs isph in children of this process. Most of a short run is the loading of a hundred libraries,
  which children find loaded. starter.py makes the requests:

    request   int, the length of the text, with the descriptors of a folder, of stdout and of
              stderr; the text: NAME=VALUE words for the environment, an empty word, and the
              words of the command, each with a zero at its end
    answers   int, the process of the child, which leads a group; int, its status as of waitpid()
*/
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define FILES 3 /* folder, stdout, stderr */

int isph_main(int argc, char **argv); /* main() of src/main.c */

/* Receives a request; returns its text, NULL at the end of all requests. */
static char *Receive(int from, int file[FILES], int *length)
{
  struct iovec  part = {.iov_base = length, .iov_len = sizeof(*length)};
  char          space[CMSG_SPACE(sizeof(int[FILES]))];
  struct msghdr message = {
      .msg_iov = &part, .msg_iovlen = 1, .msg_control = space, .msg_controllen = sizeof(space)};
  struct cmsghdr *files;
  char           *text;

  if (recvmsg(from, &message, MSG_WAITALL) != (ssize_t)sizeof(*length)) return NULL;
  files = CMSG_FIRSTHDR(&message);
  if (!files || *length <= 0) return NULL;
  (void)memcpy(file, CMSG_DATA(files), sizeof(int[FILES]));
  text = malloc((size_t)*length);
  if (!text || recv(from, text, (size_t)*length, MSG_WAITALL) != *length) return NULL;
  return text;
}

/* Runs isph as the text says. */
static int Run(char *text, int length, const int file[FILES])
{
  char **argv = calloc((size_t)length + 1, sizeof(*argv)), *word = text;
  int    null = open("/dev/null", O_RDONLY), argc = 0;

  if (!argv || null < 0 || setsid() < 0 || fchdir(file[0])) return 127;
  if (dup2(null, 0) < 0 || dup2(file[1], 1) < 0 || dup2(file[2], 2) < 0) return 127;
  (void)close(null);
  for (int k = 0; k < FILES; k++) (void)close(file[k]);
  for (; *word; word += strlen(word) + 1) (void)putenv(word);
  for (word++; word < text + length; word += strlen(word) + 1) argv[argc++] = word;
  return isph_main(argc, argv);
}

int main(int argc, char **argv)
{
  const int requests = argc == 2 ? atoi(argv[1]) : -1;
  int       file[FILES], length;
  char     *text;

  while ((text = Receive(requests, file, &length))) {
    const pid_t child  = fork();
    int         status = 0;

    if (child == 0) {
      (void)close(requests);
      exit(Run(text, length, file));
    }
    free(text);
    for (int k = 0; k < FILES; k++) (void)close(file[k]);
    if (child < 0 || write(requests, &child, sizeof(child)) < 0) return 1;
    if (waitpid(child, &status, 0) < 0 || write(requests, &status, sizeof(status)) < 0) return 1;
  }
  return 0;
}
