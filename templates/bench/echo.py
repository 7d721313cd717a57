"""A participant that sends back what it receives, changed a little so that no two windows are alike."""

from sandglass_participant import connect

participant = connect()
received, sent = ("answer", "question") if participant.wants("question") else ("question", "answer")


def advance():
    values = participant.receive(received)
    values[0] = participant.window.index
    participant.send(sent, values)


participant.serve(advance)
